// The memory that a peer can make a session take, with everything that it may send, is at most the stated
// one.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "afferent/io/links/session.hpp"
#include "tests/io/links/hello_message.hpp"
#include "tests/io/links/memory_in_use.hpp"

namespace afferent {
namespace {

// A link whose peer is the test.
class MeasuredLink final : public Link {
  public:
    void start(LinkCallbacks callbacks) override { callbacks_ = std::move(callbacks); }
    bool send(const proto::Envelope& message) override {
        sent_bytes = writer_.stream_frame(message).size();
        return true;
    }
    void close() override {}
    std::size_t queued_bytes() const override { return 0; }
    bool ordered() const override { return false; }  // so that nothing ends the session
    const LinkCounts& counts() const override { return counts_; }

    // As a stream does it: into the reader, message by message.
    void arrive(std::span<const std::byte> bytes) {
        while (!bytes.empty()) {
            const auto space = reader_.space();
            const std::size_t count = std::min(space.size(), bytes.size());
            std::copy_n(bytes.begin(), count, space.begin());
            reader_.filled(count);
            bytes = bytes.subspan(count);
            for (;;) {
                const Result<bool> next = reader_.next(message_);
                most_bytes = std::max(most_bytes, bytes_in_use());
                if (reader_.lost()) return;
                if (next && !next.value()) break;
                if (next)
                    callbacks_.message(message_);
                else
                    callbacks_.bad_frame(next.error());
                most_bytes = std::max(most_bytes, bytes_in_use());
            }
        }
    }

    std::size_t most_bytes = 0;
    std::size_t sent_bytes = 0;

  private:
    LinkCallbacks callbacks_;
    FrameReader reader_;
    FrameWriter writer_;
    proto::Envelope message_;
    LinkCounts counts_;
};

class Client final : public HandClient {
  public:
    void welcomed(const proto::Hello&) override {}
    void received(const Reception&) override {}
    proto::Bye answer_bye(const proto::Bye&) override { return {}; }
    void ended(const SessionEnd&) override {}
};

// Frames that unpack to as much as they can, up to the longest that may be sent.
std::vector<proto::Envelope> worst_messages() {
    std::vector<proto::Envelope> messages;
    const auto fill = [&](const auto& add) {
        proto::Envelope message;
        while (message.ByteSizeLong() < max_message_bytes - 4096)
            for (int i = 0; i < 500; ++i) add(message);
        messages.push_back(message);
    };
    fill([](proto::Envelope& message) { message.mutable_hello()->add_patch(); });
    fill([](proto::Envelope& message) { message.mutable_hello()->add_patch()->mutable_neuron(); });
    fill([](proto::Envelope& message) { message.mutable_samples()->add_force_n(1); });
    fill([](proto::Envelope& message) {
        message.mutable_hello()
            ->GetReflection()
            ->MutableUnknownFields(message.mutable_hello())
            ->AddVarint(99, 1);
    });
    fill([](proto::Envelope& message) {
        message.GetReflection()->MutableUnknownFields(&message)->AddGroup(99);
    });
    proto::Envelope long_packet;
    long_packet.set_position(1);
    long_packet.set_payload(std::string(max_message_bytes - 64, '\xff'));
    messages.push_back(long_packet);
    proto::Envelope long_name;
    *long_name.mutable_hello() = hello_of_nine();
    long_name.mutable_hello()->add_patch()->set_name(std::string(max_message_bytes - 256, 'x'));
    messages.push_back(long_name);
    return messages;
}

TEST(SessionMemory, StaysUnderItsBoundWhateverThePeerSends) {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the sanitizer has an allocator of its own";
#endif
    FrameWriter writer;
    std::size_t most = 0;
    for (const proto::Envelope& message : worst_messages()) {
        const std::size_t before = bytes_in_use();
        auto owned = std::make_unique<MeasuredLink>();
        MeasuredLink& link = *owned;
        Client client;
        proto::Hello expected = hello_of_nine();
        expected.add_patch();
        HandSession session(std::move(owned), expected, client);
        session.start();
        // Before the handshake and, if it comes to that, after it.
        proto::Envelope hello;
        *hello.mutable_hello() = expected;
        for (const proto::Envelope* each :
             {&message, static_cast<const proto::Envelope*>(&hello), &message, &message}) {
            const auto frame = writer.stream_frame(*each);
            link.arrive({frame.begin(), frame.end()});
        }
        most = std::max(most, link.most_bytes - before);
        // The answer is short, however long the question was.
        EXPECT_LT(link.sent_bytes, 4096U);
    }
    EXPECT_LT(most, max_session_bytes);
    EXPECT_GT(most, max_session_bytes / 10) << "the bound says little";
}

}  // namespace
}  // namespace afferent
