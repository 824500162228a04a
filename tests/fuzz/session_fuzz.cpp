// A peer that sends any messages, to either role: the session ends at most once, and its reports make sense.
#include <optional>

#include "afferent/io/links/session.hpp"
#include "fuzz.hpp"

namespace afferent {
namespace {

// The peer is the fuzzer.
class FuzzLink final : public Link {
  public:
    explicit FuzzLink(LinkCallbacks& callbacks, bool ordered) : callbacks_(callbacks), ordered_(ordered) {}
    void start(LinkCallbacks callbacks) override { callbacks_ = std::move(callbacks); }
    bool send(const proto::Envelope& message) override {
        writer_.datagram(message);
        return true;
    }
    void close() override {}
    std::size_t queued_bytes() const override { return 0; }
    bool ordered() const override { return ordered_; }
    const LinkCounts& counts() const override { return counts_; }

  private:
    LinkCallbacks& callbacks_;
    bool ordered_;
    FrameWriter writer_;
    LinkCounts counts_;
};

struct Client final : CoprocessorClient, HandClient {
    void welcomed() override {}
    void welcomed(const proto::Hello&) override {}
    void samples(const proto::Samples& samples) override { must(samples.time_ns() >= 0); }
    void clock(TimePoint time) override { must(time >= scene_start); }
    void received(const Reception& reception) override { must(reception.known.begin <= reception.known.end); }
    std::optional<TimePoint> scene_time() const override { return scene_start + 1s; }
    proto::Bye answer_bye(const proto::Bye&) override { return {}; }
    void ended(const SessionEnd&) override { must(++ends == 1); }
    int ends = 0;
};

proto::Hello some_hello() {
    proto::Hello hello;
    describe(PacketLayout{.addresses = 9}, hello);
    hello.set_freeze_ms(60);
    hello.set_safe_ms(150);
    return hello;
}

}  // namespace
}  // namespace afferent

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    FuzzInput input(data, size);
    const std::uint8_t choice = input.byte();
    MonotonicTime now{};
    const auto clock = [&now] { return now; };
    Client client;
    LinkCallbacks callbacks;
    auto link = std::make_unique<FuzzLink>(callbacks, (choice & 1) != 0);
    std::unique_ptr<Session> session;
    if ((choice & 2) != 0)
        session =
            std::make_unique<HandSession>(std::move(link), some_hello(), client, SessionLimits{}, clock);
    else
        session = std::make_unique<CoprocessorSession>(std::move(link), some_hello(), client, SessionLimits{},
                                                       clock);
    session->start();
    // Most inputs are to get beyond the handshake.
    proto::Envelope opening;
    if ((choice & 2) != 0)
        *opening.mutable_hello() = some_hello();
    else
        opening.mutable_answer()->set_welcome(true);
    if ((choice & 4) == 0) callbacks.message(opening);
    while (!input.empty() && session->state() != Session::State::ended) {
        now += std::chrono::milliseconds(input.byte());
        session->poll();
        if (session->state() == Session::State::ended) break;
        const auto body = input.bytes(input.byte());
        proto::Envelope message;
        if (message.ParseFromArray(body.data(), static_cast<int>(body.size())))
            callbacks.message(message);
        else
            callbacks.bad_frame({Error::Kind::malformed, "not a message"});
    }
    must(client.ends == (session->state() == Session::State::ended ? 1 : 0));
    return 0;
}
