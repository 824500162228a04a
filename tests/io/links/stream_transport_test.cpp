// Who is let in, who is turned away, and how often a connector tries: with peers that are made up.
#include "afferent/io/links/stream_transport.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <string>
#include <vector>

#include "afferent/io/wire/message_types.hpp"
#include "afferent/proto/aer.pb.h"

namespace afferent {
namespace {

using std::chrono::milliseconds;
using SteadyClock = std::chrono::steady_clock;

class MadeUpPeer final : public StreamPeer {
  public:
    void start(LinkCallbacks) override {}
    bool send(const proto::Envelope& message) override {
        refusals.push_back((message.answer().busy() ? "busy: " : "") + message.answer().refusal());
        return true;
    }
    void close() override { alive = false; }
    std::size_t queued_bytes() const override { return 0; }
    bool ordered() const override { return true; }
    const LinkCounts& counts() const override { return counts_; }
    bool lives() const override { return alive; }
    void abort() override { aborted = true; }
    void await_first(OnFirst on_first) override { first = std::move(on_first); }
    SteadyClock::time_point last_heard() const override { return heard; }
    void give_way(const Error& reason) override { gave_way = reason.text; }

    void say_hello() const {
        proto::Envelope message;
        message.mutable_hello();
        first(&message);
    }

    OnFirst first;
    std::vector<std::string> refusals;
    SteadyClock::time_point heard = SteadyClock::now();
    std::string gave_way;
    bool alive = true;
    bool aborted = false;

  private:
    LinkCounts counts_;
};

class StreamListening : public testing::Test {
  protected:
    struct Acceptor final : ConnectionAcceptor {
        explicit Acceptor(StreamListening& test) : test_(test) {}
        void start(OnStreamPeer on_peer) override {
            ++test_.started_;
            test_.on_peer_ = std::move(on_peer);
        }
        StreamListening& test_;
    };

    void listen(milliseconds alive_limit) {
        LinkOptions options;
        options.alive_limit = alive_limit;
        listener_ =
            make_stream_listener(io_, TcpAddress{"127.0.0.1", 1}, std::make_unique<Acceptor>(*this), options);
        listener_->start([this](std::unique_ptr<Link> link) { links_.push_back(std::move(link)); });
    }
    std::shared_ptr<MadeUpPeer> connect() const {
        auto peer = std::make_shared<MadeUpPeer>();
        on_peer_(std::shared_ptr<StreamPeer>(peer));
        return peer;
    }

    boost::asio::io_context io_;
    int started_ = 0;
    OnStreamPeer on_peer_;
    std::vector<std::unique_ptr<Link>> links_;
    std::unique_ptr<Listener> listener_;
};

TEST_F(StreamListening, LetsInWhoBeginsWithAHelloAlone) {
    listen(std::chrono::hours(1));
    const auto other = connect();
    const auto changed = connect();
    const auto gone = connect();
    const auto first = connect();
    proto::Envelope clock;
    clock.mutable_clock();
    other->first(&clock);
    EXPECT_EQ(other->refusals, std::vector<std::string>{"the first message is not a hello"});
    EXPECT_FALSE(other->alive);
    changed->first(Error{Error::Kind::checksum, "a frame fails its checksum"});
    EXPECT_EQ(changed->refusals, std::vector<std::string>{"a frame fails its checksum"});
    gone->first(Error{Error::Kind::closed, "the peer has closed"});
    EXPECT_TRUE(gone->refusals.empty()) << "nobody is there to be told";
    EXPECT_EQ(listener_->refused_peers(), 3U);
    EXPECT_TRUE(links_.empty());
    first->say_hello();
    EXPECT_EQ(links_.size(), 1U);
    on_peer_(Error{Error::Kind::not_allowed, "it has no certificate"});
    EXPECT_EQ(listener_->refused_peers(), 4U);
    EXPECT_EQ(std::get<TcpAddress>(listener_->address()).port, 1);
}

TEST_F(StreamListening, LetsAnotherInOnceTheFirstIsSilentForTooLong) {
    listen(std::chrono::hours(1));
    const auto first = connect();
    first->say_hello();
    first->heard = SteadyClock::now() - std::chrono::minutes(59);
    const auto early = connect();
    early->say_hello();
    EXPECT_EQ(early->refusals, std::vector<std::string>{"busy: another coprocessor is connected"});
    EXPECT_EQ(listener_->refused_peers(), 1U);
    EXPECT_EQ(first->gave_way, "");
    first->heard -= std::chrono::minutes(2);
    const auto second = connect();
    second->say_hello();
    EXPECT_NE(first->gave_way.find("another has taken its place"), std::string::npos);
    EXPECT_NE(first->gave_way.find(" 36600"), std::string::npos) << "61 minutes, in ms: " << first->gave_way;
    EXPECT_EQ(links_.size(), 2U);
    // The second has the place now, until its connection ends.
    connect()->say_hello();
    EXPECT_EQ(links_.size(), 2U);
    second->alive = false;
    connect()->say_hello();
    EXPECT_EQ(links_.size(), 3U);
    EXPECT_EQ(second->gave_way, "");
}

TEST_F(StreamListening, KeepsTheFirstHoweverLongItIsSilentWhereThereIsNoLimit) {
    listen(milliseconds(0));
    const auto first = connect();
    first->say_hello();
    first->heard = SteadyClock::now() - std::chrono::hours(24);
    connect()->say_hello();
    EXPECT_EQ(links_.size(), 1U);
}

TEST_F(StreamListening, AcceptsOnceHoweverOftenItIsStarted) {
    listen(milliseconds(0));
    int told = 0;
    listener_->start([&](const std::unique_ptr<Link>&) { ++told; });
    EXPECT_EQ(started_, 1);
    connect()->say_hello();
    EXPECT_EQ(told, 1);
    EXPECT_TRUE(links_.empty());
}

TEST_F(StreamListening, TurnsAwayWhoHasNotSpokenWhenItEnds) {
    listen(milliseconds(0));
    const auto silent = connect();
    const auto late = connect();
    const auto first = late->first;
    listener_.reset();
    EXPECT_TRUE(silent->aborted);
    proto::Envelope hello;
    hello.mutable_hello();
    first(&hello);
    EXPECT_TRUE(links_.empty());
}

// Pauses of 1, 2, 4, 8 and 16 ms; the one of 32 ms would end after the limit.
TEST(StreamConnector, TriesAgainAfterPausesThatDouble) {
    struct Attempt final : ConnectionAttempt {
        Attempt(int& tried, Error::Kind kind) : tried_(tried), kind_(kind) {}
        void start(OnStreamPeer on_peer) override {
            ++tried_;
            on_peer(Error{kind_, "nobody is there"});
        }
        void call_off() override {}
        int& tried_;
        Error::Kind kind_;
    };
    for (const auto& [kind, most, said] :
         {std::tuple(Error::Kind::unreachable, 6, "tcp:127.0.0.1:1: nobody is there (tried for 60 ms)"),
          std::tuple(Error::Kind::not_allowed, 1, "tcp:127.0.0.1:1: nobody is there")}) {
        boost::asio::io_context io;
        int tried = 0;
        const auto connector =
            make_stream_connector(io, TcpAddress{"127.0.0.1", 1},
                                  std::unique_ptr<ConnectionAttempt>(std::make_unique<Attempt>(tried, kind)),
                                  {milliseconds(1), milliseconds(1000), milliseconds(60)});
        for (int again = 0; again < 2; ++again) {
            tried = 0;
            std::string reason;
            connector->start(
                [&](const Result<std::unique_ptr<Link>>& link) { reason = link ? "" : link.error().text; });
            io.restart();
            io.run();
            EXPECT_EQ(reason, said);
            EXPECT_GT(tried, most / 6);
            EXPECT_LE(tried, most);
        }
    }
}

}  // namespace
}  // namespace afferent
