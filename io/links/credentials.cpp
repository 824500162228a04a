#include "afferent/io/links/credentials.hpp"

#include <openssl/crypto.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <memory>
#include <string>

#include "afferent/io/links/key_file.hpp"
#include "afferent/io/links/secret_memory.hpp"

namespace afferent {
namespace {

Error credentials_error(const std::filesystem::path& file, const std::string& text) {
    return {Error::Kind::not_allowed, file.string() + ": " + text};
}

// OpenSSL keeps private keys on this heap, where there is one: locked, and left out of core dumps.
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
        pem.view_.reset(::BIO_new_mem_buf(pem.text_.bytes().data(), static_cast<int>(count)));
        return pem;
    }

    BIO* get() const noexcept { return view_.get(); }

  private:
    static constexpr std::size_t longest = std::size_t{16} * 1024;

    SecretMemory text_{longest + 1};
    std::unique_ptr<BIO, int (*)(BIO*)> view_{nullptr, ::BIO_free};
};

using HeldCertificate = std::unique_ptr<X509, decltype(&::X509_free)>;

Result<HeldCertificate> read_certificate(const std::filesystem::path& file) {
    AFFERENT_TRY(pem, Pem::read(file, KeyFile::open));
    HeldCertificate certificate(::PEM_read_bio_X509(pem.get(), nullptr, nullptr, nullptr), ::X509_free);
    if (!certificate) return credentials_error(file, "is not a certificate");
    return certificate;
}

void release_certificate(void*, void* certificate, CRYPTO_EX_DATA*, int, long, void*) {
    ::X509_free(static_cast<X509*>(certificate));
}

// The index at which a context holds the certificate that its peers must have.
int pinned_index() {
    static const int index = ::SSL_CTX_get_ex_new_index(0, nullptr, nullptr, nullptr, release_certificate);
    return index;
}

// TLS makes the peer prove that it has the key.
int is_pinned(X509_STORE_CTX* store, void* pinned) {
    const bool same = ::X509_cmp(::X509_STORE_CTX_get0_cert(store), static_cast<const X509*>(pinned)) == 0;
    ::X509_STORE_CTX_set_error(store, same ? X509_V_OK : X509_V_ERR_CERT_REJECTED);
    return same ? 1 : 0;
}

}  // namespace

Result<void> use_credentials(SSL_CTX* context, const TlsCredentials& credentials) {
    start_secure_heap();
    AFFERENT_TRY(own, read_certificate(credentials.certificate));
    AFFERENT_TRY(key_text, Pem::read(credentials.private_key, KeyFile::secret));
    AFFERENT_TRY(pinned, read_certificate(credentials.peer_certificate));
    // An encrypted key is refused without asking for a password.
    const auto no_password = [](char*, int, int, void*) { return -1; };
    const std::unique_ptr<EVP_PKEY, decltype(&::EVP_PKEY_free)> key(
        ::PEM_read_bio_PrivateKey(key_text.get(), nullptr, no_password, nullptr), ::EVP_PKEY_free);
    if (::SSL_CTX_use_certificate(context, own.get()) != 1)
        return credentials_error(credentials.certificate, "is a certificate that OpenSSL does not take");
    // Fails for a null key, and for a key that does not belong to the certificate.
    if (::SSL_CTX_use_PrivateKey(context, key.get()) != 1)
        return credentials_error(credentials.private_key,
                                 "is not the key of " + credentials.certificate.string());
    ::SSL_CTX_set_num_tickets(context, 0);
    ::SSL_CTX_set_options(context, SSL_OP_NO_TICKET | SSL_OP_NO_RENEGOTIATION);
    ::SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
    ::SSL_CTX_set_verify(context, SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, nullptr);
    ::SSL_CTX_set_cert_verify_callback(context, is_pinned, pinned.get());
    if (::SSL_CTX_set_ex_data(context, pinned_index(), pinned.get()) != 1)
        return credentials_error(credentials.peer_certificate, "does not fit in memory");
    (void)pinned.release();
    return success();
}

}  // namespace afferent
