// What afferents read of the elements, by itself.
#include "afferent/encoders/receptive_fields.hpp"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

std::pair<std::uint32_t, std::uint32_t> range(const ElementRange& read) { return {read.begin, read.end}; }

using Range = std::pair<std::uint32_t, std::uint32_t>;

TEST(ReceptiveFieldRows, AreReadFromTheirFirstElementToTheirLast) {
    const ReceptiveFields fields(8, {{{5, 1}, {2, 1}}, {{4, 1}}, {{7, 0.5}, {6, 2}}});
    EXPECT_EQ(fields.elements(), 8U);
    EXPECT_EQ(fields.afferents(), 3U);
    EXPECT_EQ(range(fields.read_by(0, 1)), (Range{2, 6}));
    EXPECT_EQ(range(fields.read_by(1, 1)), (Range{4, 5}));
    EXPECT_EQ(range(fields.read_by(2, 1)), (Range{6, 8}));
    EXPECT_EQ(range(fields.read_by(1, 2)), (Range{4, 8}));
    EXPECT_EQ(range(fields.read_by(0, 3)), (Range{2, 8}));
}

TEST(ReceptiveFieldRows, OfOneElementEachTakeNoMemoryAndReadTheirOwn) {
    const ReceptiveFields fields = ReceptiveFields::one_each(8);
    EXPECT_TRUE(fields.is_one_each());
    EXPECT_EQ(fields.afferents(), 8U);
    EXPECT_EQ(range(fields.read_by(3, 2)), (Range{3, 5}));
    EXPECT_EQ(fields.sum(3, std::vector<double>{0, 0, 0, 2.5, 0, 0, 0, 0}), 2.5);
}

TEST(ReceptiveFieldRows, AddUpTheirElementsInOrder) {
    const ReceptiveFields fields(3, {{{2, 0.5}, {0, 2}}, {{1, 3}}});
    EXPECT_EQ(fields.row(0)[0], (FieldWeight{0, 2}));
    EXPECT_EQ(fields.row(0)[1], (FieldWeight{2, 0.5}));
    const std::vector<double> of_element{1, 10, 4};
    EXPECT_EQ(fields.sum(0, of_element), 2 * 1 + 0.5 * 4);
    EXPECT_EQ(fields.sum(1, of_element), 30);
}

TEST(ReceptiveFieldRows, NameTheWeightThatIsWrong) {
    const auto refusal = [](const std::vector<FieldWeight>& row) -> std::string {
        FieldRows rows{{{0, 1}}};
        rows.add_row(row);
        try {
            ReceptiveFields(3, std::move(rows));
        } catch (const ParameterError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_EQ(refusal({{2, 1}}), "accepted");
    EXPECT_EQ(refusal({}), "field.weight must be given at least once, is none");
    EXPECT_EQ(refusal({{3, 1}}), "field.weight.element must be below the number of elements, is 3");
    EXPECT_EQ(refusal({{1, 1}, {0, 1}, {1, 2}}), "field.weight.element must be given once in a field, is 1");
    EXPECT_EQ(refusal({{1, 0}}), "field.weight.weight must be > 0, is 0");
}

}  // namespace
}  // namespace afferent
