// One end of a DTLS 1.2 handshake; its datagrams are carried by the caller. The handshake yields the keys of
// a session; no other data passes through DTLS (as in DTLS-SRTP, RFC 5764).
//
// Until there are keys nothing authenticates a datagram, and OpenSSL gives up at the first that does not fit.
// The connector therefore numbers its records from a random number of 47 bits, the listener goes on from the
// number of the hello that it accepts, and each end drops what is not numbered like that: it was made by
// somebody who has not seen the other end's datagrams.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/io/links/datagram_codec.hpp"
#include "afferent/io/links/datagram_port.hpp"
#include "afferent/io/links/tls.hpp"
#include "afferent/runtime/result.hpp"

struct ssl_ctx_st;
struct ssl_st;

namespace afferent {

// Serves any number of handshakes.
using DtlsContext = std::shared_ptr<::ssl_ctx_st>;

// Ephemeral keys (ECDHE), both certificates, an extended master secret. Serves both ends.
Result<DtlsContext> make_dtls_context(const TlsCredentials& credentials);

// Whether it is a datagram of DTLS, by its first byte (RFC 7983): no sealed datagram begins like this.
bool is_dtls(std::span<const std::byte> datagram);
// The parts of a client hello that a listener looks at before OpenSSL does. The random bytes tell one attempt
// from another.
using DtlsRandom = std::array<std::byte, 32>;
struct ClientHello {
    DtlsRandom random;
    std::span<const std::byte> cookie;  // empty at first
};
std::optional<ClientHello> client_hello(std::span<const std::byte> datagram);

// The cookie that a peer has to return before the listener remembers it (RFC 6347, 4.2.1).
using DtlsCookie = std::array<unsigned char, 32>;
// The first is sent to peers; each is accepted.
using DtlsCookies = std::array<DtlsCookie, 2>;
inline constexpr std::size_t cookie_bytes = std::tuple_size_v<DtlsCookie>;
bool is_one_of(std::span<const std::byte> cookie, const DtlsCookies& cookies);
// The datagram that answers this hello and asks for the cookie. It is shorter than the hello, and is made
// without OpenSSL.
using DtlsCookieRequest = std::array<std::byte, 13 + 12 + 3 + cookie_bytes>;
DtlsCookieRequest cookie_request(std::span<const std::byte> hello, const DtlsCookie& cookie);

class DtlsHandshake {
  public:
    enum class Role { connects, listens };
    enum class State { under_way, done, failed };
    using Send = std::function<void(std::span<const std::byte>)>;

    // `send` is called from within the calls below.
    DtlsHandshake(DtlsContext context, Role role, const DatagramLine& line, Send send);
    ~DtlsHandshake();
    DtlsHandshake(const DtlsHandshake&) = delete;
    DtlsHandshake& operator=(const DtlsHandshake&) = delete;

    // For a listener that has kept no state of this peer. True: the hello came with one of these cookies, and
    // start() goes on from there. False: nothing has changed.
    bool listen(std::span<const std::byte> datagram, const DtlsCookies& cookies);

    void start() { advance(); }
    void receive(std::span<const std::byte> datagram);
    // Repeats a flight that is unanswered, when it is time. OpenSSL decides when, by the system's wall clock,
    // and cannot be given another clock; how long a handshake may take is decided here.
    void look_after();
    // How long look_after() may wait.
    std::chrono::microseconds pause() const;

    State state() const noexcept { return state_; }
    // Why it failed. This proves nothing: anybody on the way can make a handshake fail.
    const std::string& failure() const noexcept { return failure_; }

    // Once the handshake is done; an error if the two ends have not agreed on secrets.
    Result<DatagramCodec> codec(DatagramCodec::Time now) const;

    // How long a handshake over this line may take until it is given up.
    static std::chrono::milliseconds patience(const DatagramLine& line);

  private:
    friend struct DtlsCallbacks;

    void advance();
    void fail(int result);
    // Whether the datagram may be the other end's. If so, it is incoming_ for OpenSSL, numbered from 0.
    bool take(std::span<const std::byte> datagram);
    // Sends what OpenSSL has numbered from 0.
    void send(std::span<const std::byte> datagram);

    DtlsContext context_;
    std::unique_ptr<::ssl_st, void (*)(::ssl_st*)> ssl_;
    Send send_;
    std::chrono::microseconds first_pause_;
    State state_ = State::under_way;
    std::string failure_;
    std::uint64_t first_number_ = 0;        // of the records without encryption
    std::uint64_t cookie_returned_at_ = 0;  // the number of the hello that returned the cookie; 0: none yet
    std::vector<std::byte> renumbered_;
    std::span<const std::byte> incoming_;
    const DtlsCookies* cookies_ = nullptr;
    bool cookie_verified_ = false;
};

}  // namespace afferent
