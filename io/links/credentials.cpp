#include "afferent/io/links/credentials.hpp"

#include <openssl/bio.h>
#include <openssl/crypto.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <memory>
#include <string>

#include "afferent/io/links/key_file.hpp"
#include "afferent/io/links/secret_memory.hpp"

namespace afferent {
namespace {

struct OpenSslRelease {
    void operator()(BIO* bio) const noexcept { ::BIO_free(bio); }
    void operator()(X509* certificate) const noexcept { ::X509_free(certificate); }
    void operator()(EVP_PKEY* key) const noexcept { ::EVP_PKEY_free(key); }
};
template <class T>
using OpenSslOwned = std::unique_ptr<T, OpenSslRelease>;

Error credentials_error(const std::filesystem::path& file, const std::string& text) {
    return {Error::Kind::not_allowed, file.string() + ": " + text};
}

// OpenSSL keeps private keys of Ed25519 on this heap, where there is one: locked, and not in core dumps.
void start_secure_heap() {
    static const int started = ::CRYPTO_secure_malloc_init(std::size_t{64} * 1024, 32);
    static_cast<void>(started);
}

// The text of a file, wiped at the end, and OpenSSL's view of it.
class Pem {
  public:
    static Result<Pem> read(const std::filesystem::path& file, KeyFile kind) {
        Pem pem;
        AFFERENT_TRY(count, read_key_file(file, kind, pem.text_.characters()));
        if (count == 0 || count > longest) return credentials_error(file, "is not a PEM file");
        pem.bio_.reset(::BIO_new_mem_buf(pem.text_.bytes().data(), static_cast<int>(count)));
        return pem;
    }

    OpenSslOwned<X509> certificate() const {
        return OpenSslOwned<X509>(::PEM_read_bio_X509(bio_.get(), nullptr, nullptr, nullptr));
    }
    // Nobody is asked for a password.
    OpenSslOwned<EVP_PKEY> private_key() const {
        const auto no_password = [](char*, int, int, void*) { return 0; };
        return OpenSslOwned<EVP_PKEY>(::PEM_read_bio_PrivateKey(bio_.get(), nullptr, no_password, nullptr));
    }

  private:
    static constexpr std::size_t longest = std::size_t{64} * 1024;

    SecretMemory text_{longest + 1};
    OpenSslOwned<BIO> bio_;
};

// Where a context keeps the certificate of its peer, and releases it.
int pinned_index() {
    static const int index = ::SSL_CTX_get_ex_new_index(
        0, nullptr, nullptr, nullptr, [](void*, void* pinned, CRYPTO_EX_DATA*, int, long, void*) {
            ::X509_free(static_cast<X509*>(pinned));
        });
    return index;
}

// The certificate itself must match; no authority is asked. The handshake makes the peer prove that it has
// the key.
int is_pinned(X509_STORE_CTX* store, void* context) {
    const auto* const pinned =
        static_cast<const X509*>(::SSL_CTX_get_ex_data(static_cast<SSL_CTX*>(context), pinned_index()));
    const X509* const shown = ::X509_STORE_CTX_get0_cert(store);
    const bool same = pinned != nullptr && shown != nullptr && ::X509_cmp(shown, pinned) == 0;
    ::X509_STORE_CTX_set_error(store, same ? X509_V_OK : X509_V_ERR_CERT_UNTRUSTED);
    return same ? 1 : 0;
}

}  // namespace

Result<void> load_credentials(SSL_CTX* context, const TlsCredentials& credentials) {
    start_secure_heap();
    AFFERENT_TRY(own, Pem::read(credentials.certificate, KeyFile::open));
    AFFERENT_TRY(secret, Pem::read(credentials.private_key, KeyFile::secret));
    AFFERENT_TRY(peer, Pem::read(credentials.peer_certificate, KeyFile::open));
    // What is wrong is said below; OpenSSL's own list of it would be found by the next handshake.
    struct ForgetErrors {
        ~ForgetErrors() { ::ERR_clear_error(); }
    } const forget_errors;
    const auto certificate = own.certificate();
    if (!certificate || ::SSL_CTX_use_certificate(context, certificate.get()) != 1)
        return credentials_error(credentials.certificate, "is not a certificate");
    const auto key = secret.private_key();
    if (!key || ::SSL_CTX_use_PrivateKey(context, key.get()) != 1 ||
        ::SSL_CTX_check_private_key(context) != 1)
        return credentials_error(credentials.private_key,
                                 "is not the key of " + credentials.certificate.string());
    auto pinned = peer.certificate();
    if (!pinned) return credentials_error(credentials.peer_certificate, "is not a certificate");
    if (::SSL_CTX_set_ex_data(context, pinned_index(), pinned.get()) != 1)
        return credentials_error(credentials.peer_certificate, "cannot be kept");
    static_cast<void>(pinned.release());
    ::SSL_CTX_set_verify(context, SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, nullptr);
    ::SSL_CTX_set_cert_verify_callback(context, is_pinned, context);
    return success();
}

}  // namespace afferent
