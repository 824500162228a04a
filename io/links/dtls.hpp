// One end of a DTLS 1.2 handshake, over datagrams that somebody else carries. What comes of it are the keys
// of a session; no other data passes through DTLS (as in DTLS-SRTP, RFC 5764).
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
#include "afferent/io/wire/result.hpp"

struct ssl_ctx_st;
struct ssl_st;

namespace afferent {

// Serves any number of handshakes.
using DtlsContext = std::shared_ptr<::ssl_ctx_st>;

// Ephemeral keys (ECDHE), both certificates, an extended master secret. Serves both ends.
Result<DtlsContext> make_dtls_context(const TlsCredentials& credentials);

// By its first byte (RFC 7983): no sealed datagram begins like this.
bool is_dtls(std::span<const std::byte> datagram);
// The client's random bytes, if this begins a handshake: they tell one attempt from another.
using DtlsRandom = std::array<std::byte, 32>;
std::optional<DtlsRandom> client_hello(std::span<const std::byte> datagram);

// What a listener wants to see again before it remembers a peer (RFC 6347, 4.2.1).
using DtlsCookie = std::array<unsigned char, 32>;
// The first is handed out; any of them is accepted.
using DtlsCookies = std::array<DtlsCookie, 2>;
// The datagram that asks for it, and by how much a hello that returns it is longer than the one before.
inline constexpr std::size_t cookie_request_bytes = 13 + 12 + 3 + std::tuple_size_v<DtlsCookie>;
inline constexpr std::size_t cookie_bytes = std::tuple_size_v<DtlsCookie>;

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

    // For a listener that keeps nothing: answers a client's hello with a cookie, and is as before. True: the
    // hello came with a cookie, and start() goes on from there.
    bool listen(std::span<const std::byte> datagram, const DtlsCookies& cookies);

    void start() { advance(); }
    void receive(std::span<const std::byte> datagram);
    // Sends again what nobody has answered, if it is time.
    void look_after();
    // How long look_after() may wait.
    std::chrono::microseconds pause() const;

    State state() const noexcept { return state_; }
    // Why it failed. Nothing of it is proven: anybody on the way can make a handshake fail.
    const std::string& failure() const noexcept { return failure_; }

    // Once it is done; an error if the two ends have not agreed on secrets.
    Result<DatagramCodec> codec(DatagramCodec::Time now) const;

    // How long a handshake over this line may take until it is given up.
    static std::chrono::milliseconds patience(const DatagramLine& line);

  private:
    friend struct DtlsCallbacks;

    void advance();
    void fail(int result);

    DtlsContext context_;
    std::unique_ptr<::ssl_st, void (*)(::ssl_st*)> ssl_;
    Send send_;
    std::chrono::microseconds first_pause_;
    State state_ = State::under_way;
    std::string failure_;
    std::span<const std::byte> incoming_;
    const DtlsCookies* cookies_ = nullptr;
    bool cookie_verified_ = false;
};

}  // namespace afferent
