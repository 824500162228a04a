// A peer that is turned away, and the files that a link's ends are known by.
#include "afferent/io/links/stream_peer.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "afferent/io/links/key_folder.hpp"
#include "afferent/io/wire/message_types.hpp"

namespace afferent {
namespace {

class RefusedPeer final : public StreamPeer {
  public:
    void start(LinkCallbacks) override {}
    bool send(const proto::Envelope& message) override {
        EXPECT_FALSE(closed) << "nobody hears what comes after the end";
        sent.push_back(message);
        return true;
    }
    void close() override { closed = true; }
    std::size_t queued_bytes() const override { return 0; }
    bool ordered() const override { return true; }
    const LinkCounts& counts() const override { return counts_; }
    bool lives() const override { return !closed; }
    void abort() override {}
    void await_first(OnFirst) override {}
    std::chrono::steady_clock::time_point last_heard() const override { return {}; }
    void give_way(const Error&) override {}

    std::vector<proto::Envelope> sent;
    bool closed = false;

  private:
    LinkCounts counts_;
};

TEST(StreamPeer, IsToldWhyItIsRefusedAndThenClosed) {
    for (const Refusal refusal : {Refusal::for_good, Refusal::for_now}) {
        RefusedPeer peer;
        refuse(peer, "not today", refusal);
        ASSERT_EQ(peer.sent.size(), 1U);
        EXPECT_FALSE(peer.sent[0].answer().welcome());
        EXPECT_EQ(peer.sent[0].answer().refusal(), "not today");
        EXPECT_EQ(peer.sent[0].answer().busy(), refusal == Refusal::for_now);
        EXPECT_TRUE(peer.closed);
    }
}

TEST(KeyFolder, NamesTheFilesOfEachEnd) {
    const KeyFolder keys{"keys"};
    EXPECT_EQ(keys.certificate(LinkEnd::hand), "keys/hand.crt");
    EXPECT_EQ(keys.private_key(LinkEnd::hand), "keys/hand.key");
    EXPECT_EQ(keys.certificate(LinkEnd::coprocessor), "keys/coprocessor.crt");
    EXPECT_EQ(keys.private_key(LinkEnd::coprocessor), "keys/coprocessor.key");
}

}  // namespace
}  // namespace afferent
