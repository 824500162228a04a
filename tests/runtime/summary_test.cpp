#include "afferent/runtime/summary.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

TEST(Summary, TurnsAnUnknownValueIntoAListOrEntries) {
    Summary list;
    EXPECT_TRUE(std::holds_alternative<std::monostate>(list.value()));
    list.push_back(3);
    list.push_back("four");
    ASSERT_EQ(list.list().size(), 2U);
    EXPECT_EQ(list.list()[0].number(), 3.0);
    ASSERT_TRUE(list.list()[1].text());
    EXPECT_EQ(*list.list()[1].text(), "four");
    EXPECT_TRUE(list.entries().empty());

    Summary entries;
    entries["b"] = 1.5;
    entries["a"] = true;
    entries["b"] = 2U;
    ASSERT_EQ(entries.entries().size(), 2U);
    EXPECT_EQ(entries.entries()[0].key, "b");
    ASSERT_TRUE(entries.find("b"));
    EXPECT_EQ(entries.find("b")->number(), 2.0);
    EXPECT_EQ(entries.find("c"), nullptr);
    ASSERT_TRUE(entries.find("a"));
    ASSERT_TRUE(std::holds_alternative<bool>(entries.find("a")->value()));
    EXPECT_TRUE(std::get<bool>(entries.find("a")->value()));
    EXPECT_TRUE(entries.list().empty());
}

TEST(Summary, HasNoNumberWhereThereIsNone) {
    EXPECT_EQ(or_null(2.5).number(), 2.5);
    EXPECT_TRUE(std::holds_alternative<std::monostate>(or_null(std::nullopt).value()));
}

}  // namespace
}  // namespace afferent
