// What a context of OpenSSL is told of a pair of ends, and which files are refused.
#include "afferent/io/links/credentials.hpp"

#include <gtest/gtest.h>
#include <openssl/crypto.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

#include "bench/short_lived_keys.hpp"

namespace afferent {
namespace {

class Credentials : public testing::Test {
  protected:
    std::string refusal() {
        const auto used = use_credentials(context_.get(), credentials_);
        return used ? "accepted" : used.error().text;
    }
    static std::string content(const std::filesystem::path& file) {
        std::ifstream in(file);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static void write(const std::filesystem::path& file, const std::string& text) {
        std::ofstream(file) << text;
    }

    ShortLivedKeys keys_;
    TlsCredentials credentials_ = keys_.credentials(LinkEnd::hand);
    std::unique_ptr<SSL_CTX, decltype(&::SSL_CTX_free)> context_{::SSL_CTX_new(::TLS_method()),
                                                                 ::SSL_CTX_free};
};

TEST_F(Credentials, MakeThePeerShowItsCertificateAndResumeNothing) {
    ASSERT_EQ(refusal(), "accepted");
    EXPECT_EQ(::SSL_CTX_get_verify_mode(context_.get()), SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT);
    EXPECT_EQ(::SSL_CTX_get_num_tickets(context_.get()), 0U);
    EXPECT_EQ(SSL_CTX_get_session_cache_mode(context_.get()), SSL_SESS_CACHE_OFF);
    EXPECT_NE(::SSL_CTX_get_options(context_.get()) & SSL_OP_NO_TICKET, 0U);
    EXPECT_NE(::SSL_CTX_get_options(context_.get()) & SSL_OP_NO_RENEGOTIATION, 0U);
    EXPECT_EQ(::CRYPTO_secure_malloc_initialized(), 1) << "where the private key is";
}

TEST_F(Credentials, AreOneCertificateItsKeyAndThatOfThePeer) {
    credentials_.private_key = keys_.folder().private_key(LinkEnd::coprocessor);
    EXPECT_EQ(refusal(),
              credentials_.private_key.string() + ": is not the key of " + credentials_.certificate.string());
    credentials_ = keys_.credentials(LinkEnd::hand);
    // A key that this level of security finds too small.
    ::SSL_CTX_set_security_level(context_.get(), 5);
    EXPECT_EQ(refusal(), credentials_.certificate.string() + ": is a certificate that OpenSSL does not take");
}

TEST_F(Credentials, AreFilesOfPemUpTo16KiB) {
    const std::string certificate = content(credentials_.peer_certificate);
    constexpr std::size_t longest = 16'384;
    write(credentials_.peer_certificate, certificate + std::string(longest - certificate.size(), '\n'));
    EXPECT_EQ(refusal(), "accepted");
    const std::string refused = credentials_.peer_certificate.string() + ": is not a PEM file";
    write(credentials_.peer_certificate, certificate + std::string(longest + 1 - certificate.size(), '\n'));
    EXPECT_EQ(refusal(), refused);
    write(credentials_.peer_certificate, "");
    EXPECT_EQ(refusal(), refused);
    write(credentials_.peer_certificate, "x");
    EXPECT_EQ(refusal(), credentials_.peer_certificate.string() + ": is not a certificate");
}

TEST_F(Credentials, LeaveNoFileOpen) {
    const auto open_files = [] {
        const std::filesystem::directory_iterator descriptors("/proc/self/fd");
        return std::distance(begin(descriptors), end(descriptors));
    };
    ASSERT_EQ(refusal(), "accepted");               // OpenSSL may keep what it opens the first time
    context_.reset(::SSL_CTX_new(::TLS_method()));  // one takes credentials once
    const auto before = open_files();
    ASSERT_EQ(refusal(), "accepted");
    EXPECT_EQ(open_files(), before);
}

TEST_F(Credentials, HaveAKeyWithoutAPassword) {
    const auto is_no_key =
        credentials_.private_key.string() + ": is not the key of " + credentials_.certificate.string();
    const std::string key = content(credentials_.private_key);
    write(credentials_.private_key, "x");
    EXPECT_EQ(refusal(), is_no_key);
    const std::unique_ptr<BIO, decltype(&::BIO_free)> text(
        ::BIO_new_mem_buf(key.data(), static_cast<int>(key.size())), ::BIO_free);
    const std::unique_ptr<EVP_PKEY, decltype(&::EVP_PKEY_free)> read(
        ::PEM_read_bio_PrivateKey(text.get(), nullptr, nullptr, nullptr), ::EVP_PKEY_free);
    ASSERT_TRUE(read);
    for (std::string password : {"secret", ""}) {
        const std::unique_ptr<BIO, decltype(&::BIO_free)> locked(::BIO_new(::BIO_s_mem()), ::BIO_free);
        ASSERT_EQ(
            ::PEM_write_bio_PKCS8PrivateKey(locked.get(), read.get(), ::EVP_aes_256_cbc(), password.data(),
                                            static_cast<int>(password.size()), nullptr, nullptr),
            1);
        char* bytes = nullptr;
        const long size = BIO_get_mem_data(locked.get(), &bytes);
        write(credentials_.private_key, std::string(bytes, static_cast<std::size_t>(size)));
        EXPECT_EQ(refusal(), is_no_key) << "and nobody is asked for the password";
    }
    write(credentials_.private_key, key);
    EXPECT_EQ(refusal(), "accepted");
}

}  // namespace
}  // namespace afferent
