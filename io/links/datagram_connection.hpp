// A connection over datagrams. For the transports; programs use transports.hpp.
#pragma once

#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "afferent/io/links/connection_link.hpp"
#include "afferent/io/links/datagram_codec.hpp"
#include "afferent/io/links/datagram_port.hpp"
#include "afferent/io/links/link.hpp"
#include "afferent/io/links/send_queue.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/message_types.hpp"

namespace afferent {

// The owner of the port passes on what it receives. Takes the memory of the queue and of a few datagrams.
// Lives as long as one of its operations is under way, which may be longer than the link that a session
// holds.
class DatagramConnection final : public Connection, public std::enable_shared_from_this<DatagramConnection> {
  public:
    // `owner` is kept alive as long as the connection lives: as a rule the object that receives for the port.
    DatagramConnection(boost::asio::io_context& io, std::shared_ptr<DatagramPort> port,
                       const DatagramPeer& peer, DatagramCodec codec, const LinkOptions& options,
                       std::shared_ptr<void> owner);

    const DatagramPeer& peer() const noexcept { return peer_; }
    // When something valid was last received.
    std::chrono::steady_clock::time_point heard() const noexcept { return heard_; }

    // Delivers what is good or overtaken. Anything else may be another session's; if it is nobody's, it is
    // counted here. The peer's address follows the newest datagram that is authentic; without keys the caller
    // has compared the address.
    DatagramCodec::Unwrapped receive(const DatagramPeer& from, std::span<const std::byte> datagram);
    void count(DatagramCodec::Unwrapped how, std::span<const std::byte> datagram);
    // A frame that came before the link existed, in that datagram; it is delivered after the start.
    void receive_first(std::vector<std::byte> frame, std::span<const std::byte> datagram);
    // The bytes that were carried for this connection before it existed.
    void count_handshake(const CarriedBytes& carried) noexcept {
        counts_.in.bytes += carried.in;
        counts_.bytes_out += carried.out;
    }
    // Counts datagrams that belong to no session.
    void count_forged(std::uint64_t datagrams) noexcept { counts_.in.forged += datagrams; }
    void writable() { write(); }
    void fail(const Error& error);

    void start(LinkCallbacks callbacks) override;
    bool send(const proto::Envelope& message) override;
    void close() override;
    void abort() override;
    bool lives() const override { return !closing_; }
    bool ordered() const override { return false; }
    std::size_t queued_bytes() const override { return queue_.bytes(); }
    const LinkCounts& counts() const override { return counts_; }

  private:
    using Clock = std::chrono::steady_clock;
    static constexpr std::chrono::milliseconds longest_farewell{500};
    // How many are sent within the limit of silence, so that several may be lost before the peer counts as
    // gone.
    static constexpr int signs_of_life = 4;

    void deliver(std::span<const std::byte> frame);
    void write();
    // Whether there is a datagram to send; it is in datagram_.
    bool has_datagram();
    void take_from_queue(std::vector<std::byte>& datagram);
    // Makes a datagram of the frame, and counts it as sent.
    void wrap(std::span<const std::byte> frame, std::vector<std::byte>& datagram);
    void look_after();
    void release();

    std::shared_ptr<DatagramPort> port_;
    DatagramLine line_;
    DatagramPeer peer_;
    DatagramCodec codec_;
    std::chrono::milliseconds silence_limit_;
    std::shared_ptr<void> owner_;
    boost::asio::steady_timer timer_;
    std::shared_ptr<const LinkCallbacks> callbacks_;
    std::optional<std::vector<std::byte>> first_;
    FrameWriter writer_;
    proto::Envelope message_;
    SendQueue queue_;
    std::vector<std::byte> frame_;
    std::vector<std::byte> opened_;
    std::vector<std::byte> datagram_;
    bool unsent_ = false;                         // datagram_ has not been sent yet
    std::deque<std::vector<std::byte>> leaving_;  // what waited when the link was closed
    bool closing_ = false;
    Clock::time_point heard_;
    Clock::time_point told_;
    Clock::time_point closed_at_;
    LinkCounts counts_;
};

}  // namespace afferent
