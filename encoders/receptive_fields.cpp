#include "afferent/encoders/receptive_fields.hpp"

#include <algorithm>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

ReceptiveFields::ReceptiveFields(std::uint32_t elements, const std::vector<std::vector<Weight>>& rows)
    : elements_(elements) {
    if (rows.empty()) return;
    const auto built = std::make_shared<Rows>();
    std::size_t entries = 0;
    for (const std::vector<Weight>& row : rows) entries += row.size();
    std::vector<Weight>& weights = built->weights;
    weights.reserve(entries);
    built->begins.reserve(rows.size() + 1);
    built->begins.push_back(0);
    for (const std::vector<Weight>& row : rows) {
        if (row.empty()) throw ParameterError("field.weight", "given at least once", "none");
        const auto begin = weights.insert(weights.end(), row.begin(), row.end());
        std::sort(begin, weights.end(),
                  [](const Weight& a, const Weight& b) { return a.element < b.element; });
        for (auto weight = begin; weight != weights.end(); ++weight) {
            require(weight->element < elements, "field.weight.element", "below the number of elements",
                    weight->element);
            require(weight == begin || weight->element != (weight - 1)->element, "field.weight.element",
                    "given once in a field", weight->element);
            require(weight->weight > 0, "field.weight.weight", "> 0", weight->weight);
        }
        built->begins.push_back(static_cast<std::uint32_t>(weights.size()));
    }
    rows_ = built;
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
