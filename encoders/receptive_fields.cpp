#include "afferent/encoders/receptive_fields.hpp"

#include <algorithm>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

ReceptiveFields::ReceptiveFields(std::uint32_t elements, const std::vector<std::vector<Weight>>& rows)
    : elements_(elements) {
    if (rows.empty()) return;
    begins_.reserve(rows.size() + 1);
    begins_.push_back(0);
    for (const std::vector<Weight>& row : rows) {
        if (row.empty()) throw ParameterError("field.weight", "given at least once", "none");
        const auto begin = weights_.insert(weights_.end(), row.begin(), row.end());
        std::sort(begin, weights_.end(),
                  [](const Weight& a, const Weight& b) { return a.element < b.element; });
        for (auto weight = begin; weight != weights_.end(); ++weight) {
            require(weight->element < elements, "field.weight.element", "below the number of elements",
                    weight->element);
            require(weight == begin || weight->element != (weight - 1)->element, "field.weight.element",
                    "given once in a field", weight->element);
            require(weight->weight > 0, "field.weight.weight", "> 0", weight->weight);
        }
        begins_.push_back(static_cast<std::uint32_t>(weights_.size()));
    }
}

}  // namespace afferent
