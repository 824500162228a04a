#include "afferent/io/links/certificate.hpp"

#include <fcntl.h>
#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <system_error>

namespace afferent {
namespace {

template <auto release>
struct Release {
    template <class T>
    void operator()(T* object) const noexcept {
        release(object);
    }
};
using Key = std::unique_ptr<EVP_PKEY, Release<::EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, Release<::X509_free>>;
using Memory = std::unique_ptr<BIO, Release<::BIO_free>>;

// Certificates do not expire: to end a pair, remove its files.
Certificate self_signed(const std::string& name, EVP_PKEY* key) {
    Certificate certificate(::X509_new());
    std::uint64_t serial = 0;
    ::RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial);
    X509_NAME* const subject = ::X509_get_subject_name(certificate.get());
    const bool made =
        ::X509_set_version(certificate.get(), X509_VERSION_3) == 1 &&
        ::ASN1_INTEGER_set_uint64(::X509_get_serialNumber(certificate.get()), serial >> 1) == 1 &&
        ::ASN1_TIME_set_string_X509(::X509_getm_notBefore(certificate.get()), "19700101000000Z") == 1 &&
        ::ASN1_TIME_set_string_X509(::X509_getm_notAfter(certificate.get()), "99991231235959Z") == 1 &&
        ::X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_UTF8,
                                     reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0) == 1 &&
        ::X509_set_issuer_name(certificate.get(), subject) == 1 &&
        ::X509_set_pubkey(certificate.get(), key) == 1 &&
        ::X509_sign(certificate.get(), key, ::EVP_sha256()) != 0;
    return made ? std::move(certificate) : nullptr;
}

Result<void> write_new(const std::filesystem::path& file, BIO* text, mode_t mode) {
    const auto failed = [&]() -> Error {
        const int code = errno;
        return {Error::Kind::not_allowed,
                file.string() + ": " +
                    (code == EEXIST ? "exists, and is not written over; name another folder"
                                    : "cannot be written: " + std::generic_category().message(code))};
    };
    const int out = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (out < 0) return failed();
    char* bytes = nullptr;
    const long count = ::BIO_get_mem_data(text, &bytes);
    const bool whole = ::write(out, bytes, static_cast<std::size_t>(count)) == count;
    if (::close(out) != 0 || !whole) return failed();
    return success();
}

}  // namespace

Result<void> write_certificate(const std::string& name, const std::filesystem::path& certificate_file,
                               const std::filesystem::path& private_key) {
    const Key key(::EVP_PKEY_Q_keygen(nullptr, nullptr, "EC", "P-256"));
    const Certificate certificate = key ? self_signed(name, key.get()) : nullptr;
    const Memory key_text(::BIO_new(::BIO_s_secmem()));
    const Memory certificate_text(::BIO_new(::BIO_s_mem()));
    if (!certificate ||
        ::PEM_write_bio_PrivateKey(key_text.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) != 1 ||
        ::PEM_write_bio_X509(certificate_text.get(), certificate.get()) != 1)
        return Error{Error::Kind::not_allowed, "OpenSSL cannot make a certificate"};
    AFFERENT_TRY(write_new(private_key, key_text.get(), 0600));
    return write_new(certificate_file, certificate_text.get(), 0644);
}

}  // namespace afferent
