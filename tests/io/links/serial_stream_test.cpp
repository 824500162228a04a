// A serial line as bytes, on a pseudo-terminal.
#include "afferent/io/links/serial_stream.hpp"

#include <gtest/gtest.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <string>
#include <vector>

#include "afferent/io/links/pseudo_terminal.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

class SerialStreams : public testing::Test {
  protected:
    boost::asio::io_context io_;
    PseudoTerminal terminal_ = value_or_throw(PseudoTerminal::open(io_));
    SerialStream stream_ = value_or_throw(SerialStream::open(terminal_.device, 115'200));
    std::vector<std::byte> read_ = std::vector<std::byte>(100);
};

TEST_F(SerialStreams, BringWhatIsWritten) {
    const std::string said("a\0b\r\n\x03", 6);
    ASSERT_TRUE(stream_.write(std::as_bytes(std::span(said))));
    std::string heard(6, ' ');
    boost::asio::read(terminal_.ours, boost::asio::buffer(heard));
    EXPECT_EQ(heard, said);
    boost::asio::write(terminal_.ours, boost::asio::buffer(said));
    std::string came;
    while (came.size() < said.size()) {
        const auto count = stream_.read(read_, 900ms);
        ASSERT_TRUE(count);
        came.append(reinterpret_cast<const char*>(read_.data()), *count);
    }
    EXPECT_EQ(came, said);
}

TEST_F(SerialStreams, DoNotWaitForRoom) {
    const std::vector<std::byte> much(100'000);
    for (int i = 0; i < 5; ++i) EXPECT_TRUE(stream_.write(much)) << "nobody reads it";
}

TEST_F(SerialStreams, SayThatNothingHasCome) {
    EXPECT_EQ(stream_.read(read_, 1ms), 0U);
    EXPECT_EQ(stream_.read(read_, -1s), 0U) << "which is no wait";
}

TEST_F(SerialStreams, SayThatTheLineHasFailed) {
    terminal_.ours.close();
    EXPECT_FALSE(stream_.read(read_, 900ms));
    const std::vector<std::byte> bytes(1);
    EXPECT_FALSE(stream_.write(bytes));
}

TEST(SerialStream, IsRefusedWhereThereIsNoLine) {
    const auto opened = SerialStream::open("/dev/null", 115'200);
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().kind, Error::Kind::unreachable);
    EXPECT_FALSE(SerialStream::open("/nowhere/tty", 115'200));
}

}  // namespace
}  // namespace afferent
