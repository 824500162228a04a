// examples/hand_node.cpp against the program.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

TEST(HandNodeExample, DrivesItsMotorByWhatACoprocessorSends) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", R"(
        duration_s: 1 source { profile { point { time_s: 0.1 force_n: 0 } point { time_s: 0.3 force_n: 6 } } }
        link { unix_socket { path: "socket" } )" + patient +
                                                          " }")
                           .string();
    Process hand({scene}, "", HAND_NODE_EXAMPLE);
    Process coprocessor({"coprocessor", scene});
    EXPECT_EQ(coprocessor.wait(), 0) << coprocessor.err();
    EXPECT_EQ(hand.wait(), 0) << hand.err();
    const std::string out = hand.out();
    EXPECT_EQ(std::count(out.begin(), out.end(), '\n'), 1000) << "one line for each step";
    EXPECT_EQ(out.find("0.000 s: command 0.000 at 0.00 N\n"), 0U) << out.substr(0, 100);
    const std::string last = out.substr(out.rfind("0.999 s"));
    EXPECT_GT(std::stod(last.substr(last.find("at ") + 3)), 2) << last;
    EXPECT_NE(hand.err().find("the session has ended: this is the end of the scene"), std::string::npos)
        << hand.err();
}

TEST(HandNodeExample, SaysWhatIsWrongWithItsLink) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", "duration_s: 1").string();
    Process hand({scene}, "", HAND_NODE_EXAMPLE);
    EXPECT_EQ(hand.wait(), 1);
    EXPECT_NE(hand.err().find("the link is in process"), std::string::npos) << hand.err();
}

}  // namespace
}  // namespace afferent
