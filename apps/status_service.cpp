#include "afferent/apps/status_service.hpp"

#include <unistd.h>

#include <array>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <cstdio>
#include <optional>

#include "afferent/apps/private_folder.hpp"
#include "afferent/io/links/acceptor.hpp"
#include "afferent/io/links/endpoints.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using asio::local::stream_protocol;
using boost::system::error_code;

// Nothing where the path is too long for a socket.
std::optional<stream_protocol::endpoint> endpoint(const Scene& scene, const std::string& link_end) {
    const auto in = private_folder();
    if (!in) return std::nullopt;
    std::array<char, 17> fingerprint{};
    std::snprintf(fingerprint.data(), fingerprint.size(), "%016llx",
                  static_cast<unsigned long long>(scene.fingerprint()));
    const auto found =
        endpoint_of(UnixAddress{(*in / (std::string(fingerprint.data()) + "-" + link_end)).string()});
    return found ? std::optional(found.value()) : std::nullopt;
}

bool answers(asio::io_context& io, const stream_protocol::endpoint& endpoint) {
    stream_protocol::socket probe(io);
    error_code error;
    probe.connect(endpoint, error);
    return !error;
}

}  // namespace

struct StatusService::State {
    State(asio::io_context& io, std::function<Summary()> status_in)
        : status(std::move(status_in)), acceptor(std::make_shared<StreamAcceptor>(io)) {}

    std::function<Summary()> status;
    std::shared_ptr<StreamAcceptor> acceptor;
    std::optional<SocketFile> file;

    static void answer(const std::shared_ptr<State>& state, StreamSocket socket) {
        const auto text = std::make_shared<const std::string>(json(state->status()));
        const auto kept = std::make_shared<StreamSocket>(std::move(socket));
        asio::async_write(*kept, asio::buffer(*text), [text, kept](const error_code&, std::size_t) {});
    }
};

StatusService::StatusService(asio::io_context& io, const Scene& scene, const std::string& link_end,
                             std::function<Summary()> status) {
    const auto at = endpoint(scene, link_end);
    if (!at || answers(io, *at)) return;
    ::unlink(at->path().c_str());
    auto state = std::make_shared<State>(io, std::move(status));
    if (listen(*state->acceptor, *at)) return;
    state->file.emplace(at->path());
    state_ = std::move(state);
    accept_each(state_->acceptor,
                [state = state_](StreamSocket socket) { State::answer(state, std::move(socket)); });
}

StatusService::~StatusService() {
    if (!state_) return;
    state_->file.reset();
    error_code ignored;
    state_->acceptor->close(ignored);
}

std::optional<Summary> ask_status(const Scene& scene, const std::string& link_end) {
    const auto at = endpoint(scene, link_end);
    if (!at) return std::nullopt;
    asio::io_context io;
    stream_protocol::socket socket(io);
    error_code error;
    socket.connect(*at, error);
    if (error) return std::nullopt;
    std::string text;
    asio::async_read(socket, asio::dynamic_buffer(text, std::size_t{1} << 20),
                     [&](const error_code& read_error, std::size_t) { error = read_error; });
    io.run_for(std::chrono::seconds(2));
    auto status = parse_summary(text);
    if (error != asio::error::eof || !status || status->entries().empty())
        return Summary{{"session", "does not answer"}};
    return status;
}

}  // namespace afferent
