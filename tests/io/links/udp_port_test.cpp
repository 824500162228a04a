// A UDP socket, and the errors that a system reports on datagrams sent before.
#include "afferent/io/links/udp_port.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <vector>

#include "tests/io/links/run_until.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

using boost::asio::ip::udp;

struct User final : DatagramPortUser {
    void received(const DatagramPeer&, std::span<const std::byte> datagram) override {
        datagrams.emplace_back(datagram.begin(), datagram.end());
    }
    void received_garbage(std::uint64_t) override {}
    void writable() override {}
    void failed(const Error& error) override { failure = error.text; }

    std::vector<std::vector<std::byte>> datagrams;
    std::string failure;
};

// Nobody listens there yet: the system reports a refusal, which anybody could have forged.
TEST(UdpPort, OutlivesRefusalsOfWhatItHasSent) {
    boost::asio::io_context io;
    const auto loopback = boost::asio::ip::make_address("127.0.0.1");
    udp::endpoint there(loopback, 0);
    { value_or_throw(open_udp_port(io, there, {}))->close(); }
    const auto port = value_or_throw(open_udp_port_to(io, there, {}));
    const auto user = std::make_shared<User>();
    port->start(user);
    const std::vector<std::byte> hello(3, std::byte{7});
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(port->send({}, hello), hello.size());
        // Loopback answers at once.
        run_all(io);
    }
    ASSERT_EQ(user->failure, "");

    udp::socket peer(io, there);
    EXPECT_EQ(port->send({}, hello), hello.size());
    std::vector<std::byte> bytes(10);
    udp::endpoint from;
    ASSERT_EQ(peer.receive_from(boost::asio::buffer(bytes), from), hello.size());
    peer.send_to(boost::asio::buffer(hello), from);
    run_until(
        io, [&] { return !user->datagrams.empty() || !user->failure.empty(); }, [] {});
    EXPECT_EQ(user->failure, "");
    EXPECT_EQ(user->datagrams, std::vector<std::vector<std::byte>>{hello});
    port->close();
}

// The burst takes three turns of the loop.
TEST(UdpPort, ReceivesEveryDatagramOfABurstAndLetsOthersHaveTheirTurn) {
    boost::asio::io_context io;
    udp::endpoint here(boost::asio::ip::make_address("127.0.0.1"), 0);
    const auto port = value_or_throw(open_udp_port(io, here, {}));
    const auto user = std::make_shared<User>();
    port->start(user);
    udp::socket peer(io, udp::v4());
    std::vector<std::vector<std::byte>> burst;
    for (unsigned i = 0; i < 130; ++i) {
        burst.push_back({std::byte(i)});
        peer.send_to(boost::asio::buffer(burst.back()), here);
    }
    EXPECT_EQ(io.poll_one(), 1U);
    EXPECT_EQ(user->datagrams.size(), 64U);
    run_all(io);
    EXPECT_EQ(user->datagrams, burst);
    port->close();
}

}  // namespace
}  // namespace afferent
