// What the afferents of a patch read of its elements.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "afferent/runtime/event.hpp"

namespace afferent {

// A sparse row of weights over the elements for each afferent. Without rows each afferent reads the element
// of its own number, at weight 1, and that takes no memory.
class ReceptiveFields {
  public:
    struct Weight {
        std::uint32_t element;
        double weight;
        bool operator==(const Weight&) const = default;
    };

    static ReceptiveFields one_each(std::uint32_t elements) { return ReceptiveFields(elements, {}); }

    // Throws ParameterError: each row has weights, of elements below `elements`, each once, finite and > 0.
    ReceptiveFields(std::uint32_t elements, const std::vector<std::vector<Weight>>& rows);

    std::uint32_t elements() const noexcept { return elements_; }
    std::uint32_t afferents() const noexcept {
        return is_one_each() ? elements_ : static_cast<std::uint32_t>(begins_.size() - 1);
    }
    bool is_one_each() const noexcept { return begins_.empty(); }

    // An afferent's weights, in the order of its elements. Only where there are rows.
    std::span<const Weight> row(std::uint32_t afferent) const noexcept {
        return std::span(weights_).subspan(begins_[afferent], begins_[afferent + 1] - begins_[afferent]);
    }

    // The sum over an afferent's row of a value that each element has.
    double sum(std::uint32_t afferent, std::span<const double> of_element) const noexcept {
        if (is_one_each()) return of_element[afferent];
        double sum = 0;
        for (const Weight& weight : row(afferent)) sum += weight.weight * of_element[weight.element];
        return sum;
    }

    std::size_t bytes() const noexcept {
        return weights_.capacity() * sizeof(Weight) + begins_.capacity() * sizeof(std::uint32_t);
    }

  private:
    std::uint32_t elements_;
    std::vector<std::uint32_t> begins_;  // of each row in weights_, and the end of the last
    std::vector<Weight> weights_;
};

}  // namespace afferent
