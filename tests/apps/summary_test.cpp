#include "afferent/apps/summary.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace afferent {
namespace {

TEST(Summary, KeepsTheOrderInWhichEntriesWereAdded) {
    Summary summary;
    summary["zeta"] = 1;
    summary["alpha"] = 2;
    summary["zeta"] = 3;
    EXPECT_EQ(json(summary), R"({"zeta":3,"alpha":2})");
}

TEST(Summary, WritesEveryKindOfValue) {
    Summary summary;
    summary["largest"] = std::numeric_limits<std::uint64_t>::max();
    summary["smallest"] = std::numeric_limits<std::int64_t>::min();
    summary["number"] = 0.5;
    summary["whole"] = 2.0;
    summary["flag"] = true;
    summary["text"] = "a \"b\"";
    summary["unknown"] = Summary();
    summary["infinite"] = std::numeric_limits<double>::infinity();
    summary["way"] = {{"lost", 1}};
    summary["rows"].push_back({{"grip_n", 1.5}});
    EXPECT_EQ(json(summary),
              R"({"largest":18446744073709551615,"smallest":-9223372036854775808,"number":0.5,"whole":2.0,)"
              R"("flag":true,"text":"a \"b\"","unknown":null,"infinite":null,"way":{"lost":1},)"
              R"("rows":[{"grip_n":1.5}]})");
}

TEST(Summary, ReadsBackWhatItWrote) {
    const std::string text = R"({"b":[1,-2,0.25,{"deep":[]}],"a":{"on":false,"text":"é","none":null}})";
    const auto summary = parse_summary(text);
    ASSERT_TRUE(summary);
    EXPECT_EQ(json(*summary), text);
    const Summary* const b = summary->find("b");
    ASSERT_NE(b, nullptr);
    EXPECT_EQ(b->list().at(2).number(), 0.25);
    const Summary* const a = summary->find("a");
    ASSERT_NE(a, nullptr);
    const Summary* const words = a->find("text");
    ASSERT_TRUE(words && words->text());
    EXPECT_EQ(*words->text(), "é");
    EXPECT_EQ(summary->find("c"), nullptr);
}

TEST(Summary, ReplacesWhatIsNotUtf8) {
    EXPECT_EQ(json(Summary{{"name", "\xff"}}), "{\"name\":\"\xef\xbf\xbd\"}");
}

TEST(Summary, RefusesWhatIsNotJson) {
    for (const char* text : {"", "{", "{\"a\":}", "nothing"}) EXPECT_FALSE(parse_summary(text)) << text;
}

TEST(Summary, SurvivesAnyNesting) {
    const std::size_t levels = 1'000'000;
    const auto summary = parse_summary(std::string(levels, '[') + std::string(levels, ']'));
    ASSERT_TRUE(summary);
    EXPECT_LT(json(*summary).size(), 100U);
}

TEST(Summary, IsPrintedInWordsAtAnyDepth) {
    testing::internal::CaptureStdout();
    print(Summary{{"to_hand", Summary{{"frames", 12}, {"lost", 3}}}, {"session", "open"}});
    EXPECT_EQ(testing::internal::GetCapturedStdout(),
              "  to hand                     \n"
              "    frames                      12\n"
              "    lost                        3\n"
              "  session                     open\n");
}

}  // namespace
}  // namespace afferent
