// The pipes in the file system. Sessions over them are tested in session_test.cpp.
#include "afferent/io/links/named_pipes.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <fstream>

#include "afferent/io/links/relay.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/proto/aer.pb.h"
#include "tests/io/links/hello_message.hpp"
#include "tests/io/links/run_until.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

class NamedPipes : public testing::Test {
  protected:
    NamedPipes() {
        std::string name = (fs::temp_directory_path() / "afferent-pipes-XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
        address_.path = folder_ / "hand";
        in_ = folder_ / "hand.in";
        out_ = folder_ / "hand.out";
    }
    ~NamedPipes() override { fs::remove_all(folder_); }

    static proto::Envelope packet(std::uint32_t position) {
        proto::Envelope message;
        message.set_position(position);
        return message;
    }

    boost::asio::io_context io_;
    fs::path folder_;
    PipesAddress address_;
    fs::path in_;
    fs::path out_;
};

TEST_F(NamedPipes, AreTheirUsersAloneAndRemovedAtTheEnd) {
    {
        const auto listener = open_listener(io_, address_);
        ASSERT_TRUE(listener) << listener.error().text;
        EXPECT_EQ(text(listener.value()->address()), "pipes:" + address_.path);
        for (const fs::path& pipe : {in_, out_}) {
            EXPECT_TRUE(fs::is_fifo(pipe));
            EXPECT_EQ(fs::status(pipe).permissions(), fs::perms::owner_read | fs::perms::owner_write);
        }
    }
    EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(NamedPipes, LeaveWhatSomebodyElseHasPutInTheirPlace) {
    {
        const auto listener = open_listener(io_, address_);
        ASSERT_TRUE(listener);
        fs::remove(in_);
        std::ofstream(in_) << "a file";
        fs::remove(out_);
        ASSERT_EQ(::mkfifo(out_.c_str(), 0600), 0);
    }
    EXPECT_TRUE(fs::is_regular_file(in_));
    EXPECT_TRUE(fs::is_fifo(out_));
}

TEST_F(NamedPipes, ReplaceThoseOfAKilledListener) {
    ASSERT_EQ(::mkfifo(in_.c_str(), 0600), 0);
    ASSERT_EQ(::mkfifo(out_.c_str(), 0600), 0);
    EXPECT_TRUE(open_listener(io_, address_));
}

TEST_F(NamedPipes, AreNotTakenFromAListenerThatLives) {
    const auto first = open_listener(io_, address_);
    ASSERT_TRUE(first);
    const auto second = open_listener(io_, address_);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().kind, Error::Kind::not_allowed);
    EXPECT_NE(second.error().text.find("in use by another listener"), std::string::npos)
        << second.error().text;
    EXPECT_TRUE(fs::is_fifo(in_));
}

TEST_F(NamedPipes, DoNotReplaceAFile) {
    std::ofstream(in_) << "a file";
    const auto listener = open_listener(io_, address_);
    ASSERT_FALSE(listener);
    EXPECT_NE(listener.error().text.find("is not a pipe"), std::string::npos) << listener.error().text;
    EXPECT_TRUE(fs::is_regular_file(in_));
}

// The first peer reads nothing and leaves: bytes for it must not reach the second.
TEST_F(NamedPipes, GiveEachPeerAPairOfItsOwn) {
    auto listener = open_listener(io_, address_);
    ASSERT_TRUE(listener);
    std::unique_ptr<Link> hand;
    listener.value()->start([&](std::unique_ptr<Link> link) { hand = std::move(link); });
    const LinkCallbacks ignore{[](const proto::Envelope&) {}, [](const Error&) {}, [](const Error&) {}};
    const auto connect = [&] {
        std::unique_ptr<Link> made;
        const auto connector = make_connector(io_, address_);
        connector->start([&](Result<std::unique_ptr<Link>> link) { made = std::move(link).value(); });
        run_until(
            io_, [&] { return made != nullptr; }, [] {});
        return made;
    };
    auto first = connect();
    first->send(hello_message());
    first->send(packet(1));
    run_until(
        io_, [&] { return hand != nullptr; }, [] {});
    bool gone = false;
    hand->start({[](const proto::Envelope&) {}, [](const Error&) {}, [&](const Error&) { gone = true; }});
    hand->send(packet(2));
    run_until(
        io_, [&] { return hand->counts().bytes_out > 0; }, [] {});
    first.reset();
    run_until(
        io_, [&] { return gone; }, [] {});
    hand.reset();

    const auto second = connect();
    std::vector<std::uint32_t> received;
    second->start({[&](const proto::Envelope& message) { received.push_back(message.position()); },
                   [](const Error&) {}, [](const Error&) {}});
    second->send(hello_message());
    second->send(packet(3));
    run_until(
        io_, [&] { return hand != nullptr; }, [] {});
    hand->start(ignore);
    hand->send(packet(4));
    run_until(
        io_, [&] { return !received.empty(); }, [] {});
    EXPECT_EQ(received, std::vector<std::uint32_t>{4});
}

TEST_F(NamedPipes, HaveNoChannelBetweenTwoProcesses) {
    const LinkAddress channel = channel_address(address_);
    EXPECT_EQ(text(channel), "pipes:" + address_.path + ".channel");
    const auto relay = Relay::open(io_, channel, address_, {});
    ASSERT_FALSE(relay);
    EXPECT_EQ(relay.error().kind, Error::Kind::not_allowed);
}

// Nothing blocks, and no signal ends the process, where the reader of a pipe is gone.
TEST_F(NamedPipes, AreWrittenToAfterThePeerHasGone) {
    auto listener = open_listener(io_, address_);
    ASSERT_TRUE(listener);
    std::unique_ptr<Link> hand;
    listener.value()->start([&](std::unique_ptr<Link> link) { hand = std::move(link); });
    std::unique_ptr<Link> coprocessor;
    const auto connector = make_connector(io_, address_);
    connector->start([&](Result<std::unique_ptr<Link>> link) { coprocessor = std::move(link).value(); });
    run_until(
        io_, [&] { return coprocessor != nullptr; }, [] {});
    std::string reason;
    coprocessor->start({[](const proto::Envelope&) {}, [](const Error&) {},
                        [&](const Error& error) { reason = error.text; }});
    coprocessor->send(hello_message());
    coprocessor->send(packet(1));
    run_until(
        io_, [&] { return hand != nullptr; }, [] {});
    hand.reset();
    for (std::uint32_t i = 2; i < 100; ++i) coprocessor->send(packet(i));
    run_until(
        io_, [&] { return !reason.empty(); }, [] {});
    EXPECT_EQ(reason, "the peer has closed the link");
}

}  // namespace
}  // namespace afferent
