#include "afferent/io/links/acceptor.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstring>
#include <utility>
#include <variant>

#include "afferent/io/links/rate_limit.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

// Accepts until the acceptor is closed. Stays alive while one of its operations is under way.
class Accepting : public std::enable_shared_from_this<Accepting> {
  public:
    Accepting(std::shared_ptr<StreamAcceptor> acceptor, std::function<void(StreamSocket)> take)
        : acceptor_(std::move(acceptor)), take_(std::move(take)), pause_(acceptor_->get_executor()) {}

    void next() {
        acceptor_->async_accept([self = shared_from_this()](const error_code& error, StreamSocket socket) {
            self->accepted(error, std::move(socket));
        });
    }

  private:
    void accepted(const error_code& error, StreamSocket socket) {
        if (!acceptor_->is_open()) return;
        if (!error) take_(std::move(socket));
        if (!acceptor_->is_open()) return;
        if (error) return wait(std::chrono::milliseconds(50));
        go_on();
    }

    void go_on() {
        const auto wait_for = limit_.take(std::chrono::steady_clock::now());
        if (wait_for.count() == 0) return next();
        wait(wait_for);
    }

    void wait(std::chrono::nanoseconds pause) {
        pause_.expires_after(pause);
        pause_.async_wait([self = shared_from_this()](const error_code&) {
            if (self->acceptor_->is_open()) self->go_on();
        });
    }

    static constexpr int accepted_per_second = 1000;
    static constexpr int accepted_at_once = 16;

    std::shared_ptr<StreamAcceptor> acceptor_;
    std::function<void(StreamSocket)> take_;
    asio::steady_timer pause_;
    RateLimit limit_{accepted_per_second, accepted_at_once};
};

}  // namespace

error_code listen(StreamAcceptor& acceptor, const StreamEndpoint& endpoint) {
    error_code error;
    acceptor.open(endpoint.protocol(), error);
    if (!error && endpoint.protocol().family() != AF_UNIX)
        acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    return error;
}

void accept_each(const std::shared_ptr<StreamAcceptor>& acceptor, std::function<void(StreamSocket)> take) {
    std::make_shared<Accepting>(acceptor, std::move(take))->next();
}

LinkAddress bound_address(const StreamAcceptor& acceptor, const LinkAddress& address) {
    LinkAddress bound = address;
    std::visit(
        [&]<class Address>(Address& one) {
            if constexpr (requires { one.host; }) {
                const StreamEndpoint found = acceptor.local_endpoint();
                tcp::endpoint endpoint;
                std::memcpy(endpoint.data(), found.data(), found.size());
                endpoint.resize(found.size());
                one.host = endpoint.address().to_string();
                one.port = endpoint.port();
            }
        },
        bound);
    return bound;
}

SocketFile::SocketFile(std::string path)
    : path_(std::move(path)), file_(identity_at(path_).value_or(FileIdentity{})) {}

SocketFile::~SocketFile() {
    if (!path_.empty() && identity_at(path_) == file_) ::unlink(path_.c_str());
}

void remove_if_abandoned(asio::io_context& io, const std::string& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0 || !S_ISSOCK(status.st_mode)) return;
    // A blocking socket would wait for a listener whose queue is full.
    StreamSocket probe(io, StreamSocket::protocol_type(asio::local::stream_protocol()));
    error_code error;
    probe.non_blocking(true, error);
    probe.connect(asio::local::stream_protocol::endpoint(path), error);
    if (error == asio::error::connection_refused) ::unlink(path.c_str());
}

}  // namespace afferent
