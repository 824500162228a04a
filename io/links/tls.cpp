#include "afferent/io/links/tls.hpp"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <utility>

#include "afferent/io/links/endpoints.hpp"
#include "afferent/io/links/key_file.hpp"
#include "afferent/io/links/socket_transport.hpp"
#include "afferent/io/links/stream_connection.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

// For the whole handshake: a peer without a certificate cannot keep its place for longer.
constexpr std::chrono::milliseconds handshake_limit{2000};

Error credentials_error(const std::filesystem::path& file, const std::string& text) {
    return {Error::Kind::not_allowed, file.string() + ": " + text};
}

Result<std::string> read_pem(const std::filesystem::path& file, KeyFile kind) {
    constexpr std::size_t longest = std::size_t{64} * 1024;
    std::string text(longest + 1, '\0');
    AFFERENT_TRY(count, read_key_file(file, kind, text));
    if (count == 0 || count > longest) return credentials_error(file, "is not a PEM file");
    text.resize(count);
    return text;
}

std::shared_ptr<X509> parse_certificate(const std::string& pem) {
    const std::unique_ptr<BIO, int (*)(BIO*)> bio(::BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())),
                                                  ::BIO_free);
    return {::PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr), ::X509_free};
}

// Our certificate and key, and the one certificate that a peer must have. Their dates are ignored: a hand may
// have no clock with the date, and a pair ends when its files are removed.
Result<std::shared_ptr<asio::ssl::context>> make_context(const TlsCredentials& credentials) {
    AFFERENT_TRY(certificate, read_pem(credentials.certificate, KeyFile::open));
    AFFERENT_TRY(key, read_pem(credentials.private_key, KeyFile::secret));
    AFFERENT_TRY(peer, read_pem(credentials.peer_certificate, KeyFile::open));
    const std::shared_ptr<X509> pinned = parse_certificate(peer);
    if (!pinned) return credentials_error(credentials.peer_certificate, "is not a certificate");

    auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls);
    ::SSL_CTX* const native = context->native_handle();
    ::SSL_CTX_set_min_proto_version(native, TLS1_3_VERSION);
    // No resumption: every session makes a full handshake.
    ::SSL_CTX_set_num_tickets(native, 0);
    ::SSL_CTX_set_session_cache_mode(native, SSL_SESS_CACHE_OFF);
    error_code error;
    context->use_certificate(asio::buffer(certificate), asio::ssl::context::pem, error);
    if (error) return credentials_error(credentials.certificate, "is not a certificate: " + error.message());
    context->use_private_key(asio::buffer(key), asio::ssl::context::pem, error);
    if (error || ::SSL_CTX_check_private_key(native) != 1)
        return credentials_error(credentials.private_key,
                                 "is not the key of " + credentials.certificate.string());
    context->set_verify_mode(asio::ssl::verify_peer | asio::ssl::verify_fail_if_no_peer_cert);
    // The certificate itself must match; no authority is asked. TLS makes the peer prove that it has the key.
    context->set_verify_callback([pinned](bool, asio::ssl::verify_context& verified) {
        ::X509_STORE_CTX* const store = verified.native_handle();
        if (::X509_STORE_CTX_get_error_depth(store) != 0) return false;
        if (::X509_cmp(::X509_STORE_CTX_get_current_cert(store), pinned.get()) != 0) return false;
        ::X509_STORE_CTX_set_error(store, X509_V_OK);
        return true;
    });
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
