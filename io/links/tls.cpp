#include "afferent/io/links/tls.hpp"

#include <openssl/err.h>
#include <openssl/ssl.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/error.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <utility>

#include "afferent/io/links/counted_stream.hpp"
#include "afferent/io/links/endpoints.hpp"
#include "afferent/io/links/rate_limit.hpp"
#include "afferent/io/links/socket_transport.hpp"
#include "afferent/io/links/stream_connection.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

Result<std::shared_ptr<asio::ssl::context>> make_context(const TlsCredentials& credentials) {
    auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls);
    ::SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_3_VERSION);
    AFFERENT_TRY(use_credentials(context->native_handle(), credentials));
    return context;
}

using TlsStream = asio::ssl::stream<CountedStream<StreamSocket>>;

struct Handshake {
    Handshake(StreamSocket socket, std::shared_ptr<asio::ssl::context> context_in)
        : context(std::move(context_in)), stream(CountedStream(std::move(socket)), *context) {}

    std::shared_ptr<asio::ssl::context> context;
    TlsStream stream;
};

// A certificate that does not fit will not fit the next time.
Error handshake_error(const error_code& error) {
    if (error.category() != asio::error::get_ssl_category())
        return {Error::Kind::unreachable, error.message()};
    switch (ERR_GET_REASON(static_cast<unsigned long>(error.value()))) {
        case SSL_R_CERTIFICATE_VERIFY_FAILED:
            return {Error::Kind::not_allowed, "the peer's certificate is not the one that we hold of it"};
        case SSL_R_WRONG_VERSION_NUMBER:
            return {Error::Kind::not_allowed, "the peer does not speak TLS 1.3; has its scene link.keys?"};
        default:
            return {Error::Kind::not_allowed, error.message()};
    }
}

void shake_hands(StreamSocket socket, const std::shared_ptr<asio::ssl::context>& context, StreamRole role,
                 const CallOff& call_off, const LinkOptions& options, const OnStreamPeer& done) {
    const auto handshake = std::make_shared<Handshake>(std::move(socket), context);
    *call_off = [weak = std::weak_ptr(handshake)] {
        error_code ignored;
        if (const auto called = weak.lock()) called->stream.lowest_layer().close(ignored);
    };
    handshake->stream.async_handshake(
        role == StreamRole::listens ? TlsStream::server : TlsStream::client,
        [handshake, options, done](const error_code& error) {
            if (error) return done(handshake_error(error));
            // The handshake was called off after its completion had been queued.
            if (!handshake->stream.lowest_layer().is_open())
                return done(handshake_error(asio::error::timed_out));
            done(std::shared_ptr<StreamPeer>(
                std::make_shared<StreamConnection<TlsStream>>(std::move(handshake->stream), options)));
        });
}

// Shared by the handshakes of a listener. Each costs about a millisecond, and anybody can ask for one.
struct Handshakes {
    std::shared_ptr<asio::ssl::context> context;
    LinkOptions options;
    RateLimit limit{50, 8};
};

// A peer that has connected. It gets the memory and the time for a handshake only after its first byte.
class Arrival : public std::enable_shared_from_this<Arrival> {
  public:
    Arrival(StreamSocket socket, std::shared_ptr<Handshakes> handshakes, CallOff call_off, OnStreamPeer done)
        : socket_(std::move(socket)),
          timer_(socket_.get_executor()),
          handshakes_(std::move(handshakes)),
          call_off_(std::move(call_off)),
          done_(std::move(done)) {}

    void wait() {
        *call_off_ = [weak = weak_from_this()] {
            error_code ignored;
            const auto self = weak.lock();
            if (!self) return;
            self->socket_.close(ignored);
            self->timer_.cancel();
        };
        socket_.async_wait(StreamSocket::wait_read, [self = shared_from_this()](const error_code& error) {
            if (error) return self->done_(handshake_error(error));
            self->look();
        });
    }

  private:
    // Every handshake begins with this byte. A plain frame that begins with it would be too short for a
    // hello.
    static constexpr unsigned char handshake_record = 22;

    void look() {
        std::array<unsigned char, 1> first{};
        error_code error;
        socket_.receive(asio::buffer(first), StreamSocket::message_peek, error);
        if (error) return done_(handshake_error(error));
        if (first[0] == handshake_record) return begin();
        refuse(*plain_connection(std::move(socket_), handshakes_->options),
               "this link has keys, and your scene has none; give it link.keys", Refusal::for_good);
        done_(Error{Error::Kind::not_allowed, "the peer does not speak TLS"});
    }

    void begin() {
        if (!socket_.is_open()) return done_(handshake_error(asio::error::timed_out));
        const auto wait = handshakes_->limit.take(std::chrono::steady_clock::now());
        if (wait.count() == 0)
            return shake_hands(std::move(socket_), handshakes_->context, StreamRole::listens, call_off_,
                               handshakes_->options, done_);
        timer_.expires_after(wait);
        timer_.async_wait([self = shared_from_this()](const error_code&) { self->begin(); });
    }

    StreamSocket socket_;
    asio::steady_timer timer_;
    std::shared_ptr<Handshakes> handshakes_;
    CallOff call_off_;
    OnStreamPeer done_;
};

Result<Secure> secured_by(const TlsCredentials& credentials, const LinkOptions& options) {
    AFFERENT_TRY(context, make_context(credentials));
    const auto handshakes = std::make_shared<Handshakes>(Handshakes{std::move(context), options});
    return Secure([handshakes](StreamSocket socket, StreamRole role, const CallOff& call_off,
                               const OnStreamPeer& done) {
        if (role == StreamRole::connects)
            return shake_hands(std::move(socket), handshakes->context, role, call_off, handshakes->options,
                               done);
        std::make_shared<Arrival>(std::move(socket), handshakes, call_off, done)->wait();
    });
}

}  // namespace

// TLS 1.3 sends records of at most 2^14 bytes, each with a header of 5, its type and a tag of 16.
inline std::uint64_t line_bytes(const TlsStream&, std::uint64_t bytes) {
    constexpr std::uint64_t record_bytes = std::uint64_t{1} << 14;
    return bytes + 22 * ((bytes + record_bytes - 1) / record_bytes);
}

std::string TlsAddress::text() const { return "tls:" + host_and_port(host, port); }

Result<std::unique_ptr<Listener>> listen_on(asio::io_context& io, const TlsAddress& address,
                                            const LinkOptions& options) {
    AFFERENT_TRY(endpoint, endpoint_of(address));
    AFFERENT_TRY(secure_it, secured_by(address.credentials, options));
    return open_socket_listener(io, address, endpoint, std::move(secure_it), options);
}

std::unique_ptr<Connector> connector_to(asio::io_context& io, const TlsAddress& address,
                                        const Patience& patience, const LinkOptions& options) {
    const auto attempt = [&]() -> Result<std::unique_ptr<ConnectionAttempt>> {
        AFFERENT_TRY(endpoint, endpoint_of(address));
        AFFERENT_TRY(secure_it, secured_by(address.credentials, options));
        return make_socket_attempt(io, endpoint, std::move(secure_it), options);
    };
    return make_stream_connector(io, address, attempt(), patience);
}

}  // namespace afferent
