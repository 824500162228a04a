// One session over a link, from the hello to the bye, for both roles.
//
// The files that make it:
//   link.hpp           sends and receives single messages; a Session owns its link
//   handshake.hpp      compares the two hellos: do both ends run the same scene and version
//   message_types.hpp  the messages, generated from proto/aer.proto
//   packet_order.hpp   a hand over datagrams: restores the order of packets that overtook each other,
//   packet_intake.hpp  then decides which of them are used, too old or lost,
//   peer_clock.hpp     by the coprocessor's clock, which it estimates from questions and answers
// start(), poll() and the messages of the peer drive a session through Session::State; whatever fails ends
// it once, with a reason (SessionEnd).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "afferent/io/links/link.hpp"
#include "afferent/io/links/packet_intake.hpp"
#include "afferent/io/links/packet_order.hpp"
#include "afferent/io/links/peer_clock.hpp"
#include "afferent/io/wire/handshake.hpp"
#include "afferent/io/wire/message_types.hpp"

namespace afferent {

// The most memory that a session and its link take, whatever the peer sends and however slowly it reads:
// mostly the longest possible frame, as Protobuf unpacks it, and the send queue. A typical session takes a
// fiftieth of that. (tests/io/links/session_memory_test.cpp)
inline constexpr std::size_t max_session_bytes = std::size_t{32} << 20;

// How long a session waits, and how many bad frames it tolerates.
struct SessionLimits {
    std::chrono::milliseconds handshake{2000};
    // How long to wait for the peer's bye after ours.
    std::chrono::milliseconds farewell{500};
    // How long to wait for copies of the peer's bye, where it may be lost and is sent several times.
    std::chrono::milliseconds copies{20};
    // Where messages may be lost: how often the hello is repeated until there is an answer, and the bye until
    // there is the peer's.
    std::chrono::milliseconds repetition{100};
    // Where messages may be late: how long a packet waits for those that it has overtaken.
    Duration overtaking{2ms};
    // An open session over a stream ends when nothing has come for this long; 0: never. A stream can be cut
    // without either end being told. Datagram links see to this themselves.
    std::chrono::milliseconds silence{1000};
    // More bad frames than this within the window end the session. During the handshake a single one does,
    // except over datagrams, where anybody can send one.
    std::uint32_t bad_frames = 8;
    std::chrono::milliseconds bad_frames_window{1000};
    // More messages than this within the window, not counting packets, what acknowledges them, and samples,
    // are bad frames: in real time no session has as many. 0: there is no limit, as in lockstep.
    std::uint32_t messages = 200;
};

struct SessionEnd {
    // Both ends have said bye. Otherwise the peer was refused, broke the protocol, or is gone.
    bool complete = false;
    std::string reason;
    // The peer's bye, if there was one: always where `complete`.
    std::optional<proto::Bye> bye = {};
    // There was no answer to the handshake, or a temporary refusal: another attempt may succeed.
    bool unanswered = false;
};

// The part common to both roles: owns the link, times the handshake, counts bad frames, ends once. Where
// messages may be lost, doubled or late, hello and bye are repeated, and messages out of turn are ignored.
class Session {
  public:
    virtual ~Session() = default;
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    enum class State { handshake, open, farewell, ended };
    State state() const noexcept { return state_; }

    // Starts the link. There are no callbacks before.
    void start();
    // Checks the time limits. To be called about every 10 ms.
    void poll();

    // The session ends with the peer's bye, or when that does not come in time. Nothing may be sent any more.
    void say_bye(const proto::Bye& bye);
    // Ends the session at once, with a message to the peer that is not waited for. Another session may
    // follow.
    void break_off(const std::string& reason);

    const LinkCounts& counts() const { return link_->counts(); }
    std::size_t queued_bytes() const { return link_->queued_bytes(); }
    // Frames with a good checksum that were refused for their content. The link counts others.
    std::uint64_t refused_messages() const noexcept { return refused_messages_; }
    // What was wrong with the last bad frame.
    const std::string& last_refusal() const noexcept { return last_refusal_; }

  protected:
    Session(std::unique_ptr<Link> link, const SessionLimits& limits, MonotonicClock clock);

    virtual void on_start() = 0;
    // Called repeatedly during the handshake where messages may be lost.
    virtual void repeat_handshake() {}
    // Called with every poll while the session is open; may end it.
    virtual void on_poll() {}
    // Every message but bye.
    virtual void on_message(const proto::Envelope& message) = 0;
    // The peer's bye, and our answer if the peer says it first.
    virtual void on_bye(const proto::Bye&) {}
    virtual proto::Bye answer_bye(const proto::Bye& theirs) = 0;
    // The last call.
    virtual void on_end(const SessionEnd& end) = 0;

    bool send(const proto::Envelope& message) { return link_->send(message); }
    void open() noexcept { state_ = State::open; }
    // From now on a single bad frame ends the session, as what comes after it could not be read.
    void need_every_frame() noexcept { needs_every_frame_ = true; }
    // Counts a bad message; too many end the session.
    void refuse(const std::string& text);
    // The same, where it is held against nobody.
    void count_refused() noexcept { ++refused_messages_; }
    void end(SessionEnd end);
    void fail(const std::string& reason) { end({.reason = reason}); }
    bool ordered() const { return link_->ordered(); }
    const SessionLimits& limits() const noexcept { return limits_; }
    MonotonicTime now() const { return clock_(); }

  private:
    // How many copies of a bye are sent by an end that then stops and cannot repeat it on request.
    static constexpr int last_words = 3;

    void receive(const proto::Envelope& message);
    void receive_bye(const proto::Bye& bye);
    void part();
    void hear_of_end(const Error& error);
    void hear_bad_frame(const std::string& text);
    void count_bad_frame(const std::string& text);
    bool are_too_many(const proto::Envelope& message);
    void begin_window();
    void send_bye(const proto::Bye& bye);
    void send_last_bye(const proto::Bye& bye);

    std::unique_ptr<Link> link_;
    SessionLimits limits_;
    MonotonicClock clock_;
    State state_ = State::handshake;
    MonotonicTime deadline_{};
    MonotonicTime last_heard_{};
    MonotonicTime repeat_at_{};
    proto::Bye last_word_;
    std::optional<proto::Bye> answer_;  // to it
    int answers_ = 0;
    MonotonicTime window_begin_{};
    bool needs_every_frame_ = false;
    std::uint32_t bad_in_window_ = 0;
    std::uint32_t messages_in_window_ = 0;
    std::uint64_t refused_messages_ = 0;
    std::string last_refusal_;
};

// What a coprocessor's session calls back. Only ended() may destroy the session.
class CoprocessorClient {
  public:
    virtual ~CoprocessorClient() = default;
    // The hand agrees: packets may be sent.
    virtual void welcomed() = 0;
    virtual void status(const proto::Status&) {}
    // Which packets the hand has; false: it cannot have them.
    virtual bool acknowledged(const proto::Acknowledgement&) { return false; }
    virtual void samples(const proto::Samples&) {}
    virtual void clock(TimePoint) {}
    // What our clock shows now, in real time; nothing before it runs. It is told to the hand.
    virtual std::optional<TimePoint> scene_time() const { return std::nullopt; }
    // How far our clock is ahead of the hand's, as the hand has measured.
    virtual void ahead(Duration) {}
    // The hand says bye first; the answer holds our totals.
    virtual proto::Bye answer_bye(const proto::Bye&) = 0;
    virtual void ended(const SessionEnd&) = 0;
};

// The end that connects, and sends packets.
//
//     CoprocessorSession session(std::move(link), hello, client);
//     session.start();  ...  client.welcomed()
//     packetizer.close(deadline, [&](const auto& packet) { session.send_packet(packet); });
class CoprocessorSession final : public Session {
  public:
    // The hello is sent as it is: its nonce must be new.
    CoprocessorSession(std::unique_ptr<Link> link, const proto::Hello& hello, CoprocessorClient& client,
                       const SessionLimits& limits = {},
                       MonotonicClock clock = std::chrono::steady_clock::now);

    // Only while open. False: older packets were dropped, and the packetizer should announce its count.
    bool send_packet(const proto::Envelope& packet) { return send(packet); }
    // Lockstep: all packets that end at or before this time have been sent.
    void send_clock(TimePoint time);

  private:
    void on_start() override { send_hello(); }
    void repeat_handshake() override { send_hello(); }
    void on_message(const proto::Envelope& message) override;
    proto::Bye answer_bye(const proto::Bye& theirs) override { return client_.answer_bye(theirs); }
    void on_end(const SessionEnd& end) override { client_.ended(end); }
    void send_hello();
    void receive_answer(const proto::Answer& answer);
    void receive_probe(const proto::Probe& probe);

    proto::Hello hello_;
    CoprocessorClient& client_;
};

// What a hand's session calls back. Only ended() may destroy the session.
class HandClient {
  public:
    virtual ~HandClient() = default;
    // A coprocessor of the same scene is connected. What was decoded before is no longer valid.
    virtual void welcomed(const proto::Hello&) = 0;
    virtual void received(const Reception&) = 0;
    // Each packet, after its reception; also one that is refused.
    virtual void packet(const proto::Envelope&) {}
    virtual void clock(TimePoint) {}
    // What our clock shows now, in real time; nothing before it runs.
    virtual std::optional<TimePoint> scene_time() const { return std::nullopt; }
    virtual proto::Bye answer_bye(const proto::Bye&) = 0;
    virtual void ended(const SessionEnd&) = 0;
};

// The end that listens, and receives packets. In real time it keeps asking for the coprocessor's clock, and
// judges packets by it: a packet older than the hello's stale_ms is stale, as every packet is until the first
// answer; one later than it can be is refused. Where the samples are the hand's, a packet's age is also
// measured from its samples by the hand's clock, and the greater of the two ages counts.
class HandSession final : public Session {
  public:
    // Hellos that differ from what is expected are refused, with the difference.
    HandSession(std::unique_ptr<Link> link, const proto::Hello& expected, HandClient& client,
                const SessionLimits& limits = {}, MonotonicClock clock = std::chrono::steady_clock::now);

    // Completed by what is known of the coprocessor's clock.
    void send_status(const proto::Status& status);
    // The feed of a simulated hand. Forces must be finite.
    void send_samples(const proto::Samples& samples);
    void send_clock(TimePoint time);

    // All zero before the welcome.
    PacketCounts receiver_counts() const { return intake_ ? intake_->receiver().counts() : PacketCounts{}; }

    const PeerClock& peer_clock() const noexcept { return peer_clock_; }
    // How far the coprocessor's clock is ahead of ours; nothing if either is unknown.
    std::optional<Duration> ahead() const;

    // When poll() is to be called, because the wait of a packet ends.
    std::optional<MonotonicTime> due() const { return order_.due(); }

    // Once welcomed.
    PacketReceiver& receiver() { return intake_->receiver(); }

  private:
    void on_start() override {}
    void on_message(const proto::Envelope& message) override;
    void on_bye(const proto::Bye& theirs) override;
    proto::Bye answer_bye(const proto::Bye& theirs) override { return client_.answer_bye(theirs); }
    void on_end(const SessionEnd& end) override;
    void answer(const proto::Hello& hello);
    void welcome();
    void hear_again(const proto::Hello& hello);
    void receive(const proto::Envelope& packet);
    // Receives a packet in its turn. False: it was refused, and that may have ended the session.
    bool receive_next(const proto::Envelope& packet, MonotonicTime arrived);
    Result<Reception> take(const proto::Envelope& packet, MonotonicTime arrived);
    // Receives the packets that need not wait any longer for those before them.
    void receive_held();
    void take_all_held();
    void on_poll() override;
    void probe();
    void receive(const proto::Echo& echo);
    bool in_real_time() const { return !expected_.lockstep(); }

    // How many of the last probes an echo may still answer.
    static constexpr std::size_t probes_under_way = 16;

    proto::Hello expected_;
    std::uint64_t nonce_ = 0;  // of the hello that was accepted
    HandClient& client_;
    std::optional<PacketIntake> intake_;
    PacketOrder order_;
    Duration span_{};  // of a packet
    PeerClock peer_clock_;
    std::array<std::optional<MonotonicTime>, probes_under_way> probed_at_;
    std::uint32_t probes_ = 0;
    MonotonicTime probe_at_{};
    proto::Envelope message_;
};

}  // namespace afferent
