#include "afferent/io/wire/printable.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

TEST(Printable, KeepsPlainTextAndReplacesWhatATerminalWouldObey) {
    EXPECT_EQ(printable(""), "");
    EXPECT_EQ(printable("from ' ' to '~'"), "from ' ' to '~'");
    EXPECT_EQ(printable("\x1b[2J\r\n\x7f\xc3\xa9"), "?[2J?????");
}

TEST(Printable, CutsALongTextAt300Characters) {
    EXPECT_EQ(printable(std::string(300, 'x')), std::string(300, 'x'));
    EXPECT_EQ(printable(std::string(301, 'x')), std::string(300, 'x'));
}

}  // namespace
}  // namespace afferent
