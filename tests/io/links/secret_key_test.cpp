#include "afferent/io/links/secret_key.hpp"

#include <gtest/gtest.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "afferent/io/links/link_address.hpp"
#include "tests/io/links/dumped_memory.hpp"

namespace afferent {
namespace {

class SecretKeyFile : public testing::Test {
  protected:
    SecretKeyFile() {
        std::string name = (std::filesystem::temp_directory_path() / "afferent-key-XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
        file_ = folder_ / "link.key";
    }
    ~SecretKeyFile() override { std::filesystem::remove_all(folder_); }

    void write(const std::string& text, mode_t mode = 0600) const {
        std::ofstream(file_, std::ios::binary | std::ios::trunc) << text;
        ASSERT_EQ(::chmod(file_.c_str(), mode), 0);
    }
    std::string text() const {
        std::ifstream in(file_, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }

    std::filesystem::path folder_;
    std::filesystem::path file_;
};

TEST_F(SecretKeyFile, IsReadAsItWasWritten) {
    const SecretKey key = SecretKey::generate();
    ASSERT_TRUE(key.write(file_));
    const auto read = SecretKey::read(file_);
    ASSERT_TRUE(read) << read.error().text;
    EXPECT_EQ(read.value(), key);
    EXPECT_FALSE(SecretKey::generate() == key);
    struct stat status {};
    ASSERT_EQ(::stat(file_.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600U);
}

TEST_F(SecretKeyFile, IsNeverWrittenOver) {
    ASSERT_TRUE(SecretKey::generate().write(file_));
    const std::string before = text();
    const auto again = SecretKey::generate().write(file_);
    ASSERT_FALSE(again);
    EXPECT_NE(again.error().text.find("exists"), std::string::npos) << again.error().text;
    EXPECT_EQ(text(), before);
}

TEST_F(SecretKeyFile, IsRefusedWhereOthersCanReadIt) {
    for (const mode_t mode : {0640, 0604, 0620, 0601}) {
        write(std::string(64, 'a') + "\n", mode);
        const auto read = SecretKey::read(file_);
        ASSERT_FALSE(read);
        EXPECT_EQ(read.error().kind, Error::Kind::not_allowed);
        EXPECT_NE(read.error().text.find("chmod 600"), std::string::npos) << read.error().text;
    }
}

TEST_F(SecretKeyFile, HoldsSixtyFourDigitsAndNothingElse) {
    for (const char* end : {"", "\n", "\r\n"}) {
        write(std::string(32, 'a') + std::string(32, 'B') + end);
        const auto read = SecretKey::read(file_);
        ASSERT_TRUE(read) << read.error().text;
        EXPECT_EQ(read.value().bytes()[0], 0xaa);
        EXPECT_EQ(read.value().bytes()[31], 0xbb);
    }
    for (const std::string& wrong :
         {std::string(), std::string(63, 'a'), std::string(65, 'a'), std::string(64, 'g'),
          std::string(64, 'a') + "\n\n", " " + std::string(63, 'a'), std::string(64, 'a') + "\nmore",
          std::string(64, '\0')}) {
        write(wrong);
        const auto read = SecretKey::read(file_);
        ASSERT_FALSE(read) << wrong;
        EXPECT_EQ(read.error().kind, Error::Kind::malformed);
        EXPECT_NE(read.error().text.find("64 hexadecimal digits"), std::string::npos) << read.error().text;
    }
    EXPECT_FALSE(SecretKey::read(folder_ / "nowhere"));
    EXPECT_FALSE(SecretKey::read(folder_));
}

TEST_F(SecretKeyFile, OfZerosIsRefused) {
    write(std::string(64, '0') + "\n");
    const auto read = SecretKey::read(file_);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().kind, Error::Kind::not_allowed);
    EXPECT_NE(read.error().text.find("all zeros"), std::string::npos) << read.error().text;
    EXPECT_TRUE(SecretKey(std::array<unsigned char, SecretKey::size>{}).is_zero());
    EXPECT_FALSE(SecretKey::generate().is_zero());
}

TEST(SecretKey, HasTheMachinesCiphersFromTheFirstUse) {
    const SecretKey key = SecretKey::generate();
    // 1: it has been done before.
    EXPECT_EQ(::sodium_init(), 1);
    const SecretKey copy = key;
    EXPECT_EQ(copy.bytes().data(), key.bytes().data());
}

// What a core dump of this process would show of some bytes.
TEST_F(SecretKeyFile, IsNotInCoreDumps) {
    const SecretKey key = SecretKey::generate();
    ASSERT_TRUE(key.write(file_));
    const auto read = SecretKey::read(file_);
    ASSERT_TRUE(read);
    const DumpedMemory dump;
    EXPECT_FALSE(dump.contains(key.bytes()));
    // The search finds what is to be found.
    const std::vector<unsigned char> in_the_open(key.bytes().begin(), key.bytes().end());
    EXPECT_TRUE(DumpedMemory().contains(in_the_open));
    static_cast<void>(read);
}

TEST(LinkAddress, IsShownWithoutItsKey) {
    const SecretKey key = SecretKey::generate();
    EXPECT_EQ(text(UnixAddress{"/run/hand.sock"}), "unix:/run/hand.sock");
    EXPECT_EQ(text(TcpAddress{"127.0.0.1", 7450}), "tcp:127.0.0.1:7450");
    EXPECT_EQ(text(UdpAddress{"::1", 7450, key}), "udp:[::1]:7450");
    EXPECT_EQ(text(SerialAddress{"/dev/ttyUSB0", 921'600, key}), "serial:/dev/ttyUSB0");
}

}  // namespace
}  // namespace afferent
