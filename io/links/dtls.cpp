#include "afferent/io/links/dtls.hpp"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sodium.h>

#include <algorithm>
#include <boost/endian/conversion.hpp>
#include <utility>

#include "afferent/io/links/credentials.hpp"
#include "afferent/io/links/secret_memory.hpp"

namespace afferent {
namespace {

using std::chrono::microseconds;

// The label for exported keys (RFC 5705, 4): keys exported under it serve no other protocol.
constexpr std::string_view exported_name = "EXPERIMENTAL afferent datagrams 1";

constexpr std::size_t record_header_bytes = 13;
constexpr std::size_t message_header_bytes = 12;
constexpr std::byte handshake_record{22};
constexpr std::byte client_hello_message{1};
constexpr std::byte cookie_request_message{3};
// A handshake has fewer records, repetitions included.
constexpr std::uint64_t most_numbers = 1 << 16;

// A record: kind, version, epoch and number, length (RFC 6347, 4.1).
struct Record {
    std::span<std::byte> bytes;

    bool is_encrypted() const { return bytes[3] != std::byte{0} || bytes[4] != std::byte{0}; }
    bool holds(std::byte message) const {
        return bytes[0] == handshake_record && bytes.size() > record_header_bytes &&
               bytes[record_header_bytes] == message;
    }
    // 48 bits, without the epoch where nothing is encrypted.
    std::uint64_t number() const { return boost::endian::load_big_u48(at()); }
    void renumber(std::uint64_t number) const { boost::endian::store_big_u48(at(), number); }

  private:
    unsigned char* at() const { return reinterpret_cast<unsigned char*>(bytes.data()) + 5; }
};

// Calls for each record of a datagram. False: it does not consist of records, or one was refused.
template <class Take>
bool for_each_record(std::span<std::byte> datagram, const Take& take) {
    while (!datagram.empty()) {
        if (datagram.size() < record_header_bytes) return false;
        const std::size_t size =
            record_header_bytes +
            boost::endian::load_big_u16(reinterpret_cast<const unsigned char*>(datagram.data()) + 11);
        if (datagram.size() < size || !take(Record{datagram.first(size)})) return false;
        datagram = datagram.subspan(size);
    }
    return true;
}

DtlsHandshake& handshake_of(const SSL* ssl) { return *static_cast<DtlsHandshake*>(SSL_get_app_data(ssl)); }

}  // namespace

// Callbacks for OpenSSL.
struct DtlsCallbacks {
    static int verify(SSL* ssl, const unsigned char* cookie, unsigned size) {
        // OpenSSL verifies the cookie a second time when the handshake goes on.
        if (handshake_of(ssl).cookie_verified_) return 1;
        const DtlsCookies* const cookies = handshake_of(ssl).cookies_;
        return cookies != nullptr && is_one_of(std::as_bytes(std::span(cookie, size)), *cookies) ? 1 : 0;
    }
    // last_us = 0 asks for the first pause.
    static unsigned next_pause(SSL* ssl, unsigned last_us) {
        constexpr unsigned longest_us = 1'000'000;
        const auto first = static_cast<unsigned>(handshake_of(ssl).first_pause_.count());
        return last_us == 0 ? first : std::max(first, std::min(2 * last_us, longest_us));
    }

    // Each read takes one datagram, each write makes one.
    static int read(BIO* bio, char* into, int room) {
        std::span<const std::byte>& incoming = static_cast<DtlsHandshake*>(::BIO_get_data(bio))->incoming_;
        BIO_clear_retry_flags(bio);
        if (incoming.empty()) {
            BIO_set_retry_read(bio);
            return -1;
        }
        const std::size_t count = std::min(incoming.size(), static_cast<std::size_t>(std::max(room, 0)));
        std::copy_n(reinterpret_cast<const char*>(incoming.data()), count, into);
        incoming = {};
        return static_cast<int>(count);
    }
    static int write(BIO* bio, const char* bytes, int count) {
        BIO_clear_retry_flags(bio);
        if (count > 0)
            static_cast<DtlsHandshake*>(::BIO_get_data(bio))
                ->send(std::as_bytes(std::span(bytes, static_cast<std::size_t>(count))));
        return count;
    }
    static long control(BIO*, int command, long, void*) { return command == BIO_CTRL_FLUSH ? 1 : 0; }

    static const BIO_METHOD* datagrams() {
        static const std::unique_ptr<BIO_METHOD, void (*)(BIO_METHOD*)> method = [] {
            std::unique_ptr<BIO_METHOD, void (*)(BIO_METHOD*)> made(
                ::BIO_meth_new(::BIO_get_new_index() | BIO_TYPE_SOURCE_SINK, "datagrams"), ::BIO_meth_free);
            ::BIO_meth_set_read(made.get(), read);
            ::BIO_meth_set_write(made.get(), write);
            ::BIO_meth_set_ctrl(made.get(), control);
            return made;
        }();
        return method.get();
    }
};

Result<DtlsContext> make_dtls_context(const TlsCredentials& credentials) {
    DtlsContext context(::SSL_CTX_new(::DTLS_method()), ::SSL_CTX_free);
    if (!context || SSL_CTX_set_min_proto_version(context.get(), DTLS1_2_VERSION) != 1 ||
        ::SSL_CTX_set_cipher_list(context.get(), "ECDHE+CHACHA20:ECDHE+AESGCM") != 1 ||
        SSL_CTX_set1_groups_list(context.get(), "X25519:P-256") != 1)
        return Error{Error::Kind::not_allowed, "OpenSSL has no DTLS 1.2 with ephemeral keys"};
    AFFERENT_TRY(use_credentials(context.get(), credentials));
    // No resumption: every session makes a full handshake.
    ::SSL_CTX_set_session_cache_mode(context.get(), SSL_SESS_CACHE_OFF);
    if (::EVP_PKEY_is_a(::SSL_CTX_get0_privatekey(context.get()), "ED25519") == 1)
        return Error{Error::Kind::not_allowed, credentials.private_key.string() +
                                                   ": is an Ed25519 key, which OpenSSL's DTLS does not take; "
                                                   "afferent keys makes another"};
    // OpenSSL would ask a socket for its MTU.
    ::SSL_CTX_set_options(context.get(), SSL_OP_NO_QUERY_MTU | SSL_OP_NO_TICKET | SSL_OP_NO_RENEGOTIATION);
    // OpenSSL generates no cookies: whoever comes without one is asked for it by cookie_request().
    ::SSL_CTX_set_cookie_verify_cb(context.get(), DtlsCallbacks::verify);
    return context;
}

bool is_dtls(std::span<const std::byte> datagram) {
    return !datagram.empty() && datagram[0] >= std::byte{20} && datagram[0] < std::byte{64};
}

std::optional<ClientHello> client_hello(std::span<const std::byte> datagram) {
    // Record: kind, version, epoch and number, length. Message: kind, length, number, fragment. Then the
    // version of the client.
    constexpr std::size_t random_at = record_header_bytes + message_header_bytes + 2;
    constexpr std::size_t session_at = random_at + std::tuple_size_v<DtlsRandom>;
    ClientHello hello;
    if (datagram.size() <= session_at) return std::nullopt;
    const auto is = [&](std::size_t at, unsigned value) { return datagram[at] == std::byte(value); };
    const bool begins = datagram[0] == handshake_record && is(1, 0xfe) && is(3, 0) && is(4, 0) &&
                        datagram[record_header_bytes] == client_hello_message;
    if (!begins) return std::nullopt;
    std::copy_n(datagram.begin() + random_at, hello.random.size(), hello.random.begin());
    // The session and the cookie, each behind its length.
    const std::size_t cookie_at = session_at + 1 + std::to_integer<std::size_t>(datagram[session_at]);
    if (datagram.size() <= cookie_at) return std::nullopt;
    const auto length = std::to_integer<std::size_t>(datagram[cookie_at]);
    if (datagram.size() <= cookie_at + length) return std::nullopt;
    hello.cookie = datagram.subspan(cookie_at + 1, length);
    return hello;
}

bool is_one_of(std::span<const std::byte> cookie, const DtlsCookies& cookies) {
    return std::any_of(cookies.begin(), cookies.end(), [&](const DtlsCookie& one) {
        return cookie.size() == one.size() && ::sodium_memcmp(one.data(), cookie.data(), one.size()) == 0;
    });
}

DtlsCookieRequest cookie_request(std::span<const std::byte> hello, const DtlsCookie& cookie) {
    // DTLS 1.0 whatever follows, and the hello's own number of the record (RFC 6347, 4.2.1).
    constexpr std::byte major{0xfe}, minor{0xff};
    constexpr std::byte body{3 + cookie_bytes}, message{message_header_bytes + 3 + cookie_bytes};
    DtlsCookieRequest request{handshake_record, major, minor};
    std::copy_n(hello.begin() + 3, 8, request.begin() + 3);
    request[record_header_bytes - 1] = message;
    request[record_header_bytes] = cookie_request_message;
    request[record_header_bytes + 3] = request[record_header_bytes + message_header_bytes - 1] = body;
    auto at = request.begin() + record_header_bytes + message_header_bytes;
    *at++ = major;
    *at++ = minor;
    *at++ = std::byte{cookie_bytes};
    std::transform(cookie.begin(), cookie.end(), at, [](unsigned char byte) { return std::byte(byte); });
    return request;
}

DtlsHandshake::DtlsHandshake(DtlsContext context, Role role, const DatagramLine& line, Send send)
    : context_(std::move(context)),
      ssl_(::SSL_new(context_.get()), ::SSL_free),
      send_(std::move(send)),
      // Long enough for both flights of a round trip, and some time on the way.
      first_pause_(std::chrono::milliseconds(100) +
                   std::chrono::duration_cast<microseconds>(2000 * line.byte_time)) {
    BIO* const bio = ssl_ ? ::BIO_new(DtlsCallbacks::datagrams()) : nullptr;
    if (bio == nullptr) throw std::bad_alloc();
    ::BIO_set_data(bio, this);
    ::BIO_set_init(bio, 1);
    ::SSL_set_bio(ssl_.get(), bio, bio);
    SSL_set_app_data(ssl_.get(), this);
    ::DTLS_set_timer_cb(ssl_.get(), DtlsCallbacks::next_pause);
    SSL_set_mtu(ssl_.get(), static_cast<long>(line.handshake_bytes));
    if (role == Role::listens) {
        ::SSL_set_accept_state(ssl_.get());
    } else {
        ::SSL_set_connect_state(ssl_.get());
        ::randombytes_buf(&first_number_, sizeof first_number_);
        first_number_ >>= 17;
    }
}

DtlsHandshake::~DtlsHandshake() = default;

bool DtlsHandshake::listen(std::span<const std::byte> datagram, const DtlsCookies& cookies) {
    // OpenSSL requires somewhere to write the peer's address, which is known here.
    const std::unique_ptr<BIO_ADDR, void (*)(BIO_ADDR*)> unused(::BIO_ADDR_new(), ::BIO_ADDR_free);
    if (const auto hello = client_hello(datagram)) {
        renumbered_.assign(datagram.begin(), datagram.end());
        first_number_ = Record{renumbered_}.number();
    }
    cookies_ = &cookies;
    cookie_verified_ = unused && take(datagram) && ::DTLSv1_listen(ssl_.get(), unused.get()) > 0;
    cookies_ = nullptr;
    incoming_ = {};
    ::ERR_clear_error();
    return cookie_verified_;
}

void DtlsHandshake::receive(std::span<const std::byte> datagram) {
    if (state_ == State::failed || !take(datagram)) return;
    if (state_ == State::under_way) {
        advance();
    } else {
        // If our last flight was lost, the peer repeats its own; reading it makes OpenSSL repeat ours.
        std::array<char, 256> nothing;
        (void)::SSL_read(ssl_.get(), nothing.data(), static_cast<int>(nothing.size()));
        ::ERR_clear_error();
    }
    incoming_ = {};
}

void DtlsHandshake::look_after() {
    if (state_ != State::under_way) return;
    ::ERR_clear_error();
    if (const long handled = DTLSv1_handle_timeout(ssl_.get()); handled < 0) fail(static_cast<int>(handled));
}

microseconds DtlsHandshake::pause() const {
    timeval left{};
    if (state_ != State::under_way || DTLSv1_get_timeout(ssl_.get(), &left) != 1) return first_pause_;
    return std::chrono::seconds(left.tv_sec) + microseconds(left.tv_usec);
}

bool DtlsHandshake::take(std::span<const std::byte> datagram) {
    renumbered_.assign(datagram.begin(), datagram.end());
    const bool connects = ::SSL_is_server(ssl_.get()) == 0;
    bool is_asked_again = false;
    const bool taken = for_each_record(renumbered_, [&](const Record& record) {
        if (record.is_encrypted()) return true;
        // Modulo 2^64: a smaller number is far off as well.
        const std::uint64_t number = record.number() - first_number_;
        // The connector's own hello may be sent back to it.
        if (number >= most_numbers || (connects && record.holds(client_hello_message))) return false;
        is_asked_again |=
            record.holds(cookie_request_message) && cookie_returned_at_ > 0 && number >= cookie_returned_at_;
        record.renumber(number);
        return true;
    });
    if (taken && is_asked_again && state_ == State::under_way) {
        state_ = State::failed;
        failure_ = "the listener does not take the cookie that was received";
    }
    if (!taken || state_ == State::failed) return false;
    incoming_ = renumbered_;
    return true;
}

void DtlsHandshake::send(std::span<const std::byte> datagram) {
    std::vector<std::byte> numbered(datagram.begin(), datagram.end());
    for_each_record(numbered, [this](const Record& record) {
        if (!record.is_encrypted()) {
            if (const auto hello = client_hello(record.bytes); hello && !hello->cookie.empty())
                cookie_returned_at_ = cookie_returned_at_ == 0 ? record.number() : cookie_returned_at_;
            record.renumber(first_number_ + record.number());
        }
        return true;
    });
    send_(numbered);
}

void DtlsHandshake::advance() {
    ::ERR_clear_error();
    const int result = ::SSL_do_handshake(ssl_.get());
    if (result == 1)
        state_ = State::done;
    else
        fail(result);
}

void DtlsHandshake::fail(int result) {
    const int error = ::SSL_get_error(ssl_.get(), result);
    if (error == SSL_ERROR_WANT_READ || error == SSL_ERROR_WANT_WRITE) return;
    state_ = State::failed;
    const unsigned long reason = ::ERR_peek_last_error();
    switch (ERR_GET_REASON(reason)) {
        case SSL_R_CERTIFICATE_VERIFY_FAILED:
            failure_ = "the peer's certificate is not the one that we hold of it";
            break;
        case SSL_R_PEER_DID_NOT_RETURN_A_CERTIFICATE:
            failure_ = "the peer has no certificate";
            break;
        case SSL_R_SSLV3_ALERT_BAD_CERTIFICATE:
            failure_ = "our certificate is not the one that the peer holds of us";
            break;
        default: {
            const char* const words = ::ERR_reason_error_string(reason);
            failure_ = std::string("the handshake failed: ") + (words != nullptr ? words : "no reason given");
        }
    }
    ::ERR_clear_error();
}

Result<DatagramCodec> DtlsHandshake::codec(DatagramCodec::Time now) const {
    SecretMemory secrets(2 * SecretKey::size);
    const bool exported =
        ::SSL_get_extms_support(ssl_.get()) == 1 &&
        ::SSL_export_keying_material(ssl_.get(), secrets.bytes().data(), secrets.bytes().size(),
                                     exported_name.data(), exported_name.size(), nullptr, 0, 0) == 1;
    if (!exported || ::sodium_is_zero(secrets.bytes().data(), secrets.bytes().size()) == 1)
        return Error{Error::Kind::not_allowed, "the handshake gives no secrets"};
    const SecretKey to_listener(secrets.bytes().first<SecretKey::size>());
    const SecretKey to_connector(secrets.bytes().last<SecretKey::size>());
    return ::SSL_is_server(ssl_.get()) == 1 ? DatagramCodec(to_connector, to_listener, now)
                                            : DatagramCodec(to_listener, to_connector, now);
}

std::chrono::milliseconds DtlsHandshake::patience(const DatagramLine& line) {
    // Time for all flights, some of them twice.
    return std::chrono::milliseconds(1000) +
           std::chrono::duration_cast<std::chrono::milliseconds>(6000 * line.byte_time);
}

}  // namespace afferent
