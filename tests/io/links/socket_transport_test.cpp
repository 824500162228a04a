// How a socket's connection begins and ends where the peer does not do its part.
#include "afferent/io/links/socket_transport.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/connect_pair.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include "afferent/io/links/waiting_line.hpp"
#include "tests/io/links/hello_message.hpp"
#include "tests/io/links/run_until.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using Local = asio::local::stream_protocol;
using std::chrono::milliseconds;

// The peer's system accepts the connection, and nobody secures it.
TEST(SocketAttempt, EndsAfterItsTimeAndCallsOffWhatIsUnderWay) {
    asio::io_context io;
    const std::string path = testing::TempDir() + "afferent-mute-" + std::to_string(::getpid());
    Local::acceptor mute(io, path);
    int called_off = 0;
    const auto secure = [&](const StreamSocket&, StreamRole, const CallOff& call_off, const OnStreamPeer&) {
        *call_off = [&] { ++called_off; };
    };
    const auto attempt = make_socket_attempt(io, mute.local_endpoint(), secure, {}, milliseconds(20));
    std::vector<std::string> reasons;
    attempt->start([&](const Result<std::shared_ptr<StreamPeer>>& peer) {
        reasons.push_back(peer ? "connected" : peer.error().text);
    });
    io.run_for(std::chrono::minutes(1));  // returns when there is nothing left to do
    EXPECT_EQ(reasons, std::vector<std::string>{"no answer within 20 ms"});
    EXPECT_EQ(called_off, 1);
    ::unlink(path.c_str());
}

// Each that is secured leaves its place, so that only those who wait compete for them.
TEST(SocketListener, TurnsNobodyAwayForThoseWhoAreSecuredAlready) {
    asio::io_context io;
    const std::string path = testing::TempDir() + "afferent-crowd-" + std::to_string(::getpid());
    std::size_t begun = 0;
    int called_off = 0;
    const auto secure = [&](const StreamSocket&, StreamRole, const CallOff& call_off,
                            const OnStreamPeer& done) {
        if (begun++ == 0)
            *call_off = [&] { ++called_off; };
        else
            done(Error{Error::Kind::closed, "a stranger"});
    };
    const auto listener =
        value_or_throw(open_socket_listener(io, UnixAddress{path}, Local::endpoint(path), secure, {}));
    listener->start([](const auto&) { ADD_FAILURE() << "nobody has said hello"; });
    const auto began = std::chrono::steady_clock::now();
    std::vector<Local::socket> peers;
    while (begun <= WaitingLine::most) {
        peers.emplace_back(io).connect(path);
        run_until(
            io, [&] { return begun == peers.size(); }, [] {});
    }
    // Its own time may be over where the machine is busy.
    EXPECT_TRUE(called_off == 0 || std::chrono::steady_clock::now() - began >= WaitingLine::patience);
    EXPECT_EQ(listener->refused_peers(), WaitingLine::most);
}

// A connection, and the socket of its peer.
class ConnectedStream : public testing::Test {
  protected:
    asio::io_context io;
    Local::socket theirs{io};
    const std::shared_ptr<StreamPeer> connection = [this] {
        Local::socket ours(io);
        asio::local::connect_pair(ours, theirs);
        return plain_connection(StreamSocket(std::move(ours)), {});
    }();
};

// As a session does that keeps its link a while.
TEST_F(ConnectedStream, LivesNoLongerThanThePeer) {
    std::string reason;
    connection->start(
        {.message = {}, .bad_frame = {}, .closed = [&](const Error& error) { reason = error.text; }});
    EXPECT_TRUE(connection->lives());
    theirs.close();
    run_all(io);
    EXPECT_EQ(reason, "the peer has closed the link");
    EXPECT_FALSE(connection->lives());
    EXPECT_FALSE(connection->send(hello_message()));
}

// A peer that sends a byte of a frame now and then does not keep another from its place.
TEST_F(ConnectedStream, HasHeardNothingBeforeAFrameIsWhole) {
    int messages = 0;
    connection->start({.message = [&](const proto::Envelope&) { ++messages; },
                       .bad_frame = [](const Error& error) { ADD_FAILURE() << error.text; },
                       .closed = [](const Error& error) { ADD_FAILURE() << error.text; }});
    FrameWriter writer;
    const auto frame = writer.stream_frame(hello_message());
    const auto began = std::chrono::steady_clock::now();
    asio::write(theirs, asio::buffer(frame.data(), frame.size() - 1));
    run_all(io);
    EXPECT_EQ(connection->last_heard(), std::chrono::steady_clock::time_point());
    asio::write(theirs, asio::buffer(&frame.back(), 1));
    run_all(io);
    EXPECT_EQ(messages, 1);
    EXPECT_GE(connection->last_heard(), began);
    connection->abort();
}

// To close a socket with unread bytes would destroy what is on its way to the peer.
TEST_F(ConnectedStream, ReadsOnAfterItWasClosedUntilThePeerClosesAsWell) {
    connection->start({[](const proto::Envelope&) { ADD_FAILURE() << "a message after the end"; },
                       [](const Error&) { ADD_FAILURE() << "a bad frame after the end"; },
                       [](const Error& error) { ADD_FAILURE() << error.text; }});
    connection->send(hello_message());
    connection->close();
    FrameWriter writer;
    const auto frame = writer.stream_frame(hello_message());
    for (int i = 0; i < 3; ++i) {
        asio::write(theirs, asio::buffer(frame.data(), frame.size()));
        run_all(io);
    }
    std::string heard;
    boost::system::error_code error;
    asio::read(theirs, asio::dynamic_buffer(heard), error);
    EXPECT_EQ(error, asio::error::eof);
    EXPECT_EQ(heard, std::string(reinterpret_cast<const char*>(frame.data()), frame.size()));
    theirs.close();
    run_all(io);
    EXPECT_TRUE(io.stopped()) << "the end of the peer was not read";
}

// A peer that is refused before anything was read of it.
TEST_F(ConnectedStream, ReadsUntilThePeerClosesAlsoIfItWasNeverStarted) {
    connection->close();
    theirs.close();
    run_all(io);
    EXPECT_TRUE(io.stopped()) << "the end of the peer was not read";
}

// What waits behind the first is counted when it is closed.
TEST_F(ConnectedStream, CountsWhatIsStillQueuedAsSentOnceItIsClosed) {
    connection->start({[](const proto::Envelope&) {}, [](const Error&) {}, [](const Error&) {}});
    for (int i = 0; i < 3; ++i) connection->send(hello_message());
    FrameWriter writer;
    const std::size_t frame = writer.stream_frame(hello_message()).size();
    EXPECT_EQ(connection->queued_bytes(), 2 * frame) << "the first is being written";
    connection->close();
    EXPECT_EQ(connection->counts().bytes_out, 3 * frame);
    std::string heard;
    boost::system::error_code error;
    run_all(io);
    asio::read(theirs, asio::dynamic_buffer(heard), error);
    EXPECT_EQ(heard.size(), 3 * frame);
}

// Packets are small, and are sent one by one: without the option the system waits for more of them.
TEST(SocketOptions, SendSmallPacketsAtOnceAndKeepBuffersSmall) {
    asio::io_context io;
    asio::ip::tcp::acceptor acceptor(io, {asio::ip::address_v4::loopback(), 0});
    asio::ip::tcp::socket near(io);
    near.connect(acceptor.local_endpoint());
    StreamSocket socket(std::move(near));
    LinkOptions options;
    options.kernel_buffer_bytes = 8192;
    tune(socket, options);
    asio::ip::tcp::no_delay no_delay;
    socket.get_option(no_delay);
    EXPECT_TRUE(no_delay.value());
    asio::socket_base::send_buffer_size buffer;
    socket.get_option(buffer);
    EXPECT_LE(buffer.value(), 2 * 8192)
        << "the system may double what is asked for, and its own buffers are larger";
}

}  // namespace
}  // namespace afferent
