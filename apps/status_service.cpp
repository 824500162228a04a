#include "afferent/apps/status_service.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "afferent/apps/failure.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using asio::local::stream_protocol;
using boost::system::error_code;

// A folder that nobody else can write to.
std::optional<std::filesystem::path> folder() {
    const char* const runtime = std::getenv("XDG_RUNTIME_DIR");
    const auto path =
        runtime ? std::filesystem::path(runtime) / "afferent"
                : std::filesystem::temp_directory_path() / ("afferent-" + std::to_string(::geteuid()));
    ::mkdir(path.c_str(), 0700);
    struct stat status {};
    if (::lstat(path.c_str(), &status) != 0 || !S_ISDIR(status.st_mode) || status.st_uid != ::geteuid() ||
        (status.st_mode & 0077) != 0)
        return std::nullopt;
    return path;
}

std::optional<std::string> socket_path(const Scene& scene, const std::string& side) {
    const auto in = folder();
    if (!in) return std::nullopt;
    std::array<char, 17> fingerprint{};
    std::snprintf(fingerprint.data(), fingerprint.size(), "%016llx",
                  static_cast<unsigned long long>(scene.fingerprint()));
    return (*in / (std::string(fingerprint.data()) + "-" + side)).string();
}

bool answers(asio::io_context& io, const std::string& path) {
    stream_protocol::socket probe(io);
    error_code error;
    probe.connect(path, error);
    return !error;
}

}  // namespace

struct StatusService::State {
    State(asio::io_context& io, std::string path_in, std::function<Summary()> status_in)
        : path(std::move(path_in)), status(std::move(status_in)), acceptor(io) {}

    std::string path;
    std::function<Summary()> status;
    stream_protocol::acceptor acceptor;

    static void accept(const std::shared_ptr<State>& state) {
        state->acceptor.async_accept([state](const error_code& error, stream_protocol::socket socket) {
            if (!state->acceptor.is_open()) return;
            if (!error) state->answer(std::move(socket));
            accept(state);
        });
    }

    void answer(stream_protocol::socket socket) const {
        const auto text = std::make_shared<const std::string>(status().dump());
        const auto kept = std::make_shared<stream_protocol::socket>(std::move(socket));
        asio::async_write(*kept, asio::buffer(*text), [text, kept](const error_code&, std::size_t) {});
    }
};

StatusService::StatusService(asio::io_context& io, const Scene& scene, const std::string& side,
                             std::function<Summary()> status) {
    const auto path = socket_path(scene, side);
    if (!path || answers(io, *path)) return;
    ::unlink(path->c_str());
    auto state = std::make_shared<State>(io, *path, std::move(status));
    error_code error;
    state->acceptor.open(stream_protocol(), error);
    if (!error) state->acceptor.bind(*path, error);
    if (!error) state->acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error) return;
    state_ = std::move(state);
    State::accept(state_);
}

StatusService::~StatusService() {
    if (!state_) return;
    error_code ignored;
    state_->acceptor.close(ignored);
    ::unlink(state_->path.c_str());
}

std::optional<Summary> ask_status(const Scene& scene, const std::string& side) {
    const auto path = socket_path(scene, side);
    if (!path) return std::nullopt;
    asio::io_context io;
    stream_protocol::socket socket(io);
    error_code error;
    socket.connect(*path, error);
    if (error) return std::nullopt;
    std::string text;
    asio::async_read(socket, asio::dynamic_buffer(text, std::size_t{1} << 20),
                     [&](const error_code& read_error, std::size_t) { error = read_error; });
    io.run_for(std::chrono::seconds(2));
    Summary status = Summary::parse(text, nullptr, false);
    if (error != asio::error::eof || !status.is_object())
        throw Failure("the " + side + " does not say how it stands");
    return status;
}

}  // namespace afferent
