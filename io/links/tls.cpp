#include "afferent/io/links/tls.hpp"

#include <openssl/err.h>
#include <openssl/ssl.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <utility>

#include "afferent/io/links/credentials.hpp"
#include "afferent/io/links/endpoints.hpp"
#include "afferent/io/links/socket_transport.hpp"
#include "afferent/io/links/stream_connection.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

// For the whole handshake: a peer without a certificate cannot keep its place for longer.
constexpr std::chrono::milliseconds handshake_limit{2000};

Result<std::shared_ptr<asio::ssl::context>> make_context(const TlsCredentials& credentials) {
    auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls);
    ::SSL_CTX* const native = context->native_handle();
    ::SSL_CTX_set_min_proto_version(native, TLS1_3_VERSION);
    // No resumption: every session makes a full handshake.
    ::SSL_CTX_set_num_tickets(native, 0);
    ::SSL_CTX_set_session_cache_mode(native, SSL_SESS_CACHE_OFF);
    AFFERENT_TRY(load_credentials(native, credentials));
    return context;
}

using TlsStream = asio::ssl::stream<StreamSocket>;

struct Handshake {
    Handshake(StreamSocket socket, std::shared_ptr<asio::ssl::context> context_in)
        : context(std::move(context_in)), stream(std::move(socket), *context), timer(stream.get_executor()) {}

    std::shared_ptr<asio::ssl::context> context;
    TlsStream stream;
    asio::steady_timer timer;
};

// A certificate that does not fit will not fit the next time.
Error handshake_error(const error_code& error) {
    const bool is_final = error.category() == asio::error::get_ssl_category();
    const bool another = is_final && ERR_GET_REASON(static_cast<unsigned long>(error.value())) ==
                                         SSL_R_CERTIFICATE_VERIFY_FAILED;
    return {is_final ? Error::Kind::not_allowed : Error::Kind::unreachable,
            another ? "the peer's certificate is not the one that we hold of it" : error.message()};
}

void secure(const std::shared_ptr<Handshake>& handshake, StreamRole role, std::function<void()>& call_off,
            const LinkOptions& options, OnConnection done) {
    call_off = [weak = std::weak_ptr(handshake)] {
        error_code ignored;
        if (const auto called = weak.lock()) called->stream.lowest_layer().close(ignored);
    };
    handshake->timer.expires_after(handshake_limit);
    handshake->timer.async_wait([call_off](const error_code& error) {
        if (!error) call_off();
    });
    handshake->stream.async_handshake(
        role == StreamRole::listens ? TlsStream::server : TlsStream::client,
        [handshake, options, done = std::move(done)](const error_code& error) {
            handshake->timer.cancel();
            if (error) return done(handshake_error(error));
            // The limit was over, but the timer's turn had not come.
            if (!handshake->stream.lowest_layer().is_open())
                return done(handshake_error(asio::error::timed_out));
            done(std::shared_ptr<Connection>(
                std::make_shared<StreamConnection<TlsStream>>(std::move(handshake->stream), options)));
        });
}

Result<Secure> secured_by(const TlsCredentials& credentials, const LinkOptions& options) {
    AFFERENT_TRY(context, make_context(credentials));
    return Secure([context = std::move(context), options](StreamSocket socket, StreamRole role,
                                                          std::function<void()>& call_off,
                                                          OnConnection done) {
        secure(std::make_shared<Handshake>(std::move(socket), context), role, call_off, options,
               std::move(done));
    });
}

}  // namespace

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
