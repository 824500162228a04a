// Datagrams to a program on this machine, which may be there or not, and may read them or not.
#include "afferent/io/links/datagram_sender.hpp"

#include <gtest/gtest.h>

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/local/datagram_protocol.hpp>
#include <filesystem>

#include "tests/temporary_folder.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

using boost::asio::ip::udp;
using LocalSocket = boost::asio::local::datagram_protocol::socket;

constexpr std::array three_bytes{std::byte{7}, std::byte{8}, std::byte{9}};

template <class Socket>
std::vector<std::byte> read_from(Socket& socket) {
    std::vector<std::byte> read(10);
    typename Socket::endpoint_type from;
    read.resize(socket.receive_from(boost::asio::buffer(read), from));
    return read;
}

TEST(DatagramSender, SendsToAUdpPort) {
    boost::asio::io_context io;
    udp::socket reader(io, udp::endpoint(boost::asio::ip::make_address("127.0.0.1"), 0));
    for (const char* host : {"127.0.0.1", "localhost"}) {
        auto sender = value_or_throw(DatagramSender::to_udp(host, reader.local_endpoint().port()));
        EXPECT_TRUE(sender.send(three_bytes));
        EXPECT_EQ(read_from(reader), std::vector(three_bytes.begin(), three_bytes.end()));
    }
}

TEST(DatagramSender, SendsToNoOtherMachine) {
    for (const char* host : {"192.0.2.1", "afferent.example", ""}) {
        const auto sender = DatagramSender::to_udp(host, 5000);
        ASSERT_FALSE(sender) << host;
        EXPECT_EQ(sender.error().kind, Error::Kind::not_allowed) << host;
    }
    EXPECT_EQ(DatagramSender::to_udp("192.0.2.1", 5000).error().text,
              "udp:192.0.2.1:5000: must be localhost or a loopback address in digits: nothing protects what "
              "is sent");
}

TEST(DatagramSender, FindsTheReaderOfAUnixSocketWheneverItComes) {
    const Folder folder;
    const std::string path = folder("events.sock");
    auto sender = value_or_throw(DatagramSender::to_unix(path));
    EXPECT_FALSE(sender.send(three_bytes)) << "nobody is there yet";
    boost::asio::io_context io;
    {
        LocalSocket reader(io, path);
        EXPECT_TRUE(sender.send(three_bytes));
        EXPECT_EQ(read_from(reader), std::vector(three_bytes.begin(), three_bytes.end()));
    }
    EXPECT_FALSE(sender.send(three_bytes)) << "it has gone";
    std::filesystem::remove(path);
    LocalSocket next(io, path);
    EXPECT_TRUE(sender.send(three_bytes));
    EXPECT_EQ(read_from(next), std::vector(three_bytes.begin(), three_bytes.end()));
}

TEST(DatagramSender, WaitsForNobodyAndSaysWhatHasNotBeenTaken) {
    const Folder folder;
    const std::string path = folder("events.sock");
    boost::asio::io_context io;
    LocalSocket reader(io, path);
    auto sender = value_or_throw(DatagramSender::to_unix(path));
    int taken = 0;
    while (taken < 1'000'000 && sender.send(three_bytes)) ++taken;
    EXPECT_LT(taken, 1'000'000) << "it never says that nobody reads";
    for (int i = 0; i < taken; ++i) ASSERT_EQ(read_from(reader).size(), three_bytes.size()) << i;
    EXPECT_TRUE(sender.send(three_bytes)) << "there is room again";
}

}  // namespace
}  // namespace afferent
