#include "afferent/io/links/secret_key.hpp"

#include <gtest/gtest.h>
#include <sodium.h>

#include <vector>

#include "afferent/io/links/link_address.hpp"
#include "tests/io/links/dumped_memory.hpp"

namespace afferent {
namespace {

TEST(SecretKey, OfZerosIsKnown) {
    EXPECT_TRUE(SecretKey(std::array<unsigned char, SecretKey::size>{}).is_zero());
    EXPECT_FALSE(SecretKey::generate().is_zero());
    EXPECT_FALSE(SecretKey::generate() == SecretKey::generate());
}

TEST(SecretKey, HasTheMachinesCiphersFromTheFirstUse) {
    const SecretKey key = SecretKey::generate();
    // 1: it has been done before.
    EXPECT_EQ(::sodium_init(), 1);
    const SecretKey copy = key;
    EXPECT_EQ(copy.bytes().data(), key.bytes().data());
}

TEST(SecretKey, IsNotInCoreDumps) {
    const SecretKey key = SecretKey::generate();
    const DumpedMemory dump;
    EXPECT_FALSE(dump.contains(key.bytes()));
    // The search finds a key that is there.
    const std::vector<unsigned char> in_the_open(key.bytes().begin(), key.bytes().end());
    EXPECT_TRUE(DumpedMemory().contains(in_the_open));
}

TEST(LinkAddress, IsShownWithoutItsKeys) {
    EXPECT_EQ(text(UnixAddress{"/run/hand.sock"}), "unix:/run/hand.sock");
    EXPECT_EQ(text(TcpAddress{"127.0.0.1", 7450}), "tcp:127.0.0.1:7450");
    EXPECT_EQ(text(UdpAddress{"::1", 7450, {}}), "udp:[::1]:7450");
    EXPECT_EQ(text(SerialAddress{"/dev/ttyUSB0", 921'600, {}}), "serial:/dev/ttyUSB0");
}

}  // namespace
}  // namespace afferent
