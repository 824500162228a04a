#include "afferent/encoders/receptive_fields.hpp"

#include <algorithm>
#include <utility>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

ReceptiveFields::ReceptiveFields(std::uint32_t elements, FieldRows rows) : elements_(elements) {
    if (rows.size() == 0) return;
    for (std::uint32_t i = 0; i < rows.size(); ++i) {
        const std::span<FieldWeight> row = rows[i];
        if (row.empty()) throw ParameterError("field.weight", "given at least once", "none");
        const auto before = [](const FieldWeight& a, const FieldWeight& b) { return a.element < b.element; };
        if (!std::is_sorted(row.begin(), row.end(), before)) std::sort(row.begin(), row.end(), before);
        for (auto weight = row.begin(); weight != row.end(); ++weight) {
            require(weight->element < elements, "field.weight.element", "below the number of elements",
                    weight->element);
            require(weight == row.begin() || weight->element != (weight - 1)->element, "field.weight.element",
                    "given once in a field", weight->element);
            require(weight->weight > 0, "field.weight.weight", "> 0", weight->weight);
        }
    }
    rows_ = std::make_shared<const FieldRows>(std::move(rows));
}

ElementRange ReceptiveFields::read_by(std::uint32_t first, std::uint32_t count) const noexcept {
    if (is_one_each()) return {first, first + count};
    ElementRange range{elements_, 0};
    for (std::uint32_t i = first; i < first + count; ++i) {
        range.begin = std::min(range.begin, row(i).front().element);
        range.end = std::max(range.end, row(i).back().element + 1);
    }
    return range;
}

}  // namespace afferent
