// What the afferents of a patch read of its elements.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "afferent/runtime/event.hpp"

namespace afferent {

// The elements begin, begin + 1, ..., end - 1 of a patch.
struct ElementRange {
    std::uint32_t begin;
    std::uint32_t end;

    std::uint32_t size() const noexcept { return end - begin; }
    bool contains(std::uint32_t element) const noexcept { return element >= begin && element < end; }
    friend bool operator==(const ElementRange&, const ElementRange&) = default;
};

// A sparse row of weights over the elements for each afferent. Without rows each afferent reads the element
// of its own number, at weight 1, and that takes no memory. Copies share their rows.
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
        return is_one_each() ? elements_ : static_cast<std::uint32_t>(rows_->begins.size() - 1);
    }
    bool is_one_each() const noexcept { return !rows_; }

    // An afferent's weights, in the order of its elements. Only where there are rows.
    std::span<const Weight> row(std::uint32_t afferent) const noexcept {
        const std::uint32_t begin = rows_->begins[afferent];
        return std::span(rows_->weights).subspan(begin, rows_->begins[afferent + 1] - begin);
    }

    // From the first to the last element that the afferents first, first + 1, ... read.
    ElementRange read_by(std::uint32_t first, std::uint32_t count) const noexcept;

    // The sum over an afferent's row of a value that each element has.
    double sum(std::uint32_t afferent, std::span<const double> of_element) const noexcept {
        if (is_one_each()) return of_element[afferent];
        double sum = 0;
        for (const Weight& weight : row(afferent)) sum += weight.weight * of_element[weight.element];
        return sum;
    }

  private:
    struct Rows {
        std::vector<std::uint32_t> begins;  // of each row in `weights`, and the end of the last
        std::vector<Weight> weights;
    };

    std::uint32_t elements_;
    std::shared_ptr<const Rows> rows_;  // null: one each
};

}  // namespace afferent
