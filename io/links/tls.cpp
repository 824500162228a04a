#include "afferent/io/links/tls.hpp"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>

#include "afferent/io/links/endpoints.hpp"
#include "afferent/io/links/key_file.hpp"
#include "afferent/io/links/stream_transport.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

// For the whole handshake. A peer without a certificate cannot hold a place longer than this.
constexpr std::chrono::milliseconds handshake_limit{2000};

Error credentials_error(const std::filesystem::path& file, const std::string& text) {
    return {Error::Kind::not_allowed, file.string() + ": " + text};
}

Result<std::string> read_pem(const std::filesystem::path& file, KeyFile kind) {
    constexpr std::size_t longest = std::size_t{64} * 1024;
    std::string text(longest + 1, '\0');
    AFFERENT_TRY(count, read_key_file(file, kind, text));
    if (count == 0 || count > longest) return credentials_error(file, "is no PEM file");
    text.resize(count);
    return text;
}

std::shared_ptr<X509> parse_certificate(const std::string& pem) {
    const std::unique_ptr<BIO, int (*)(BIO*)> bio(::BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())),
                                                  ::BIO_free);
    return {::PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr), ::X509_free};
}

// Ours to show, and the one peer's to insist on. The dates in certificates are not looked at: a hand may have
// no clock that knows the date, and a pair is ended by taking its files away.
Result<std::shared_ptr<asio::ssl::context>> make_context(const TlsCredentials& credentials) {
    AFFERENT_TRY(certificate, read_pem(credentials.certificate, KeyFile::open));
    AFFERENT_TRY(key, read_pem(credentials.private_key, KeyFile::secret));
    AFFERENT_TRY(peer, read_pem(credentials.peer_certificate, KeyFile::open));
    const std::shared_ptr<X509> pinned = parse_certificate(peer);
    if (!pinned) return credentials_error(credentials.peer_certificate, "is no certificate");

    auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls);
    ::SSL_CTX* const native = context->native_handle();
    ::SSL_CTX_set_min_proto_version(native, TLS1_3_VERSION);
    // Each session proves itself anew.
    ::SSL_CTX_set_num_tickets(native, 0);
    ::SSL_CTX_set_session_cache_mode(native, SSL_SESS_CACHE_OFF);
    error_code error;
    context->use_certificate(asio::buffer(certificate), asio::ssl::context::pem, error);
    if (error) return credentials_error(credentials.certificate, "is no certificate: " + error.message());
    context->use_private_key(asio::buffer(key), asio::ssl::context::pem, error);
    if (error || ::SSL_CTX_check_private_key(native) != 1)
        return credentials_error(credentials.private_key,
                                 "is not the key of " + credentials.certificate.string());
    context->set_verify_mode(asio::ssl::verify_peer | asio::ssl::verify_fail_if_no_peer_cert);
    // Not whom somebody vouches for, but the very certificate. That the peer has its key, TLS makes it prove.
    context->set_verify_callback([pinned](bool, asio::ssl::verify_context& verified) {
        ::X509_STORE_CTX* const store = verified.native_handle();
        if (::X509_STORE_CTX_get_error_depth(store) != 0) return false;
        if (::X509_cmp(::X509_STORE_CTX_get_current_cert(store), pinned.get()) != 0) return false;
        ::X509_STORE_CTX_set_error(store, X509_V_OK);
        return true;
    });
    return context;
}

class Secured {
  public:
    using Stream = asio::ssl::stream<tcp::socket>;

    explicit Secured(std::shared_ptr<asio::ssl::context> context) : context_(std::move(context)) {}

    template <class Done>
    void operator()(tcp::socket socket, StreamRole role, std::function<void()>& call_off, Done done) const {
        const auto attempt = std::make_shared<Attempt>(std::move(socket), context_);
        call_off = [weak = std::weak_ptr(attempt)] {
            error_code ignored;
            if (const auto called = weak.lock()) called->stream.lowest_layer().close(ignored);
        };
        attempt->timer.expires_after(handshake_limit);
        attempt->timer.async_wait([call_off](const error_code& error) {
            if (!error) call_off();
        });
        attempt->stream.async_handshake(
            role == StreamRole::listens ? Stream::server : Stream::client,
            [attempt, done = std::move(done)](const error_code& error) {
                attempt->timer.cancel();
                // Too late to be seen by the timer, and closed all the same.
                const bool late = !error && !attempt->stream.lowest_layer().is_open();
                done(late ? error_code(asio::error::timed_out) : error, std::move(attempt->stream));
            });
    }
    // A certificate that does not fit will not fit the next time.
    static bool is_final(const error_code& error) {
        return error && error.category() == asio::error::get_ssl_category();
    }
    static std::string words(const error_code& error) {
        const bool another =
            ERR_GET_REASON(static_cast<unsigned long>(error.value())) == SSL_R_CERTIFICATE_VERIFY_FAILED;
        return another ? "the peer's certificate is not the one that we hold of it" : error.message();
    }

  private:
    struct Attempt {
        Attempt(tcp::socket socket, std::shared_ptr<asio::ssl::context> context_in)
            : context(std::move(context_in)),
              stream(std::move(socket), *context),
              timer(stream.get_executor()) {}

        std::shared_ptr<asio::ssl::context> context;
        Stream stream;
        asio::steady_timer timer;
    };

    std::shared_ptr<asio::ssl::context> context_;
};

Result<Secured> make_secured(const TlsCredentials& credentials) {
    AFFERENT_TRY(context, make_context(credentials));
    return Secured(std::move(context));
}

}  // namespace

Result<std::unique_ptr<Listener>> open_tls_listener(asio::io_context& io, const TlsAddress& address,
                                                    const LinkOptions& options) {
    AFFERENT_TRY(found, endpoint_of(address));
    AFFERENT_TRY(secured, make_secured(address.credentials));
    return open_stream_listener<tcp>(
        io, address, found, std::move(secured),
        [credentials = address.credentials](const tcp::endpoint& bound) {
            return TlsAddress{bound.address().to_string(), bound.port(), credentials};
        },
        options);
}

std::unique_ptr<Connector> make_tls_connector(asio::io_context& io, const TlsAddress& address,
                                              const Patience& patience, const LinkOptions& options) {
    return std::make_unique<StreamConnector<tcp, Secured>>(
        io, address, endpoint_of(address), make_secured(address.credentials), patience, options);
}

}  // namespace afferent
