// What the afferents of a patch read of its elements.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
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

// How much an afferent reads of an element.
struct FieldWeight {
    std::uint32_t element;
    double weight;
    bool operator==(const FieldWeight&) const = default;
};

// Rows of weights, one behind the other in memory.
class FieldRows {
  public:
    FieldRows() = default;
    FieldRows(std::initializer_list<std::initializer_list<FieldWeight>> rows) {
        for (const auto& row : rows) add_row(row);
    }

    // The weights that follow, up to end_row(), are one row.
    void add(const FieldWeight& weight) { weights_.push_back(weight); }
    void end_row() { begins_.push_back(static_cast<std::uint32_t>(weights_.size())); }
    void add_row(std::span<const FieldWeight> row) {
        weights_.insert(weights_.end(), row.begin(), row.end());
        end_row();
    }
    void reserve(std::size_t rows, std::size_t weights) {
        begins_.reserve(rows + 1);
        weights_.reserve(weights);
    }

    std::uint32_t size() const noexcept { return static_cast<std::uint32_t>(begins_.size() - 1); }
    // The weights that were added since the last end_row().
    std::span<FieldWeight> last() noexcept { return std::span(weights_).subspan(begins_.back()); }
    std::span<FieldWeight> operator[](std::uint32_t row) noexcept {
        return std::span(weights_).subspan(begins_[row], begins_[row + 1] - begins_[row]);
    }
    std::span<const FieldWeight> operator[](std::uint32_t row) const noexcept {
        return std::span(weights_).subspan(begins_[row], begins_[row + 1] - begins_[row]);
    }

  private:
    std::vector<std::uint32_t> begins_{0};  // of each row, and the end of the last
    std::vector<FieldWeight> weights_;
};

// A sparse row of weights over the elements for each afferent. Without rows each afferent reads the element
// of its own number, at weight 1, and that takes no memory. Copies share their rows.
class ReceptiveFields {
  public:
    static ReceptiveFields one_each(std::uint32_t elements) { return ReceptiveFields(elements, {}); }

    // Throws ParameterError: each row has weights, of elements below `elements`, each once, finite and > 0.
    ReceptiveFields(std::uint32_t elements, FieldRows rows);

    std::uint32_t elements() const noexcept { return elements_; }
    std::uint32_t afferents() const noexcept { return is_one_each() ? elements_ : rows_->size(); }
    bool is_one_each() const noexcept { return !rows_; }

    // An afferent's weights, in the order of its elements. Only where there are rows.
    std::span<const FieldWeight> row(std::uint32_t afferent) const noexcept { return (*rows_)[afferent]; }

    // From the first to the last element that the afferents first, first + 1, ... read.
    ElementRange read_by(std::uint32_t first, std::uint32_t count) const noexcept;

    // The sum over an afferent's row of a value that each element has.
    double sum(std::uint32_t afferent, std::span<const double> of_element) const noexcept {
        if (is_one_each()) return of_element[afferent];
        double sum = 0;
        for (const FieldWeight& weight : row(afferent)) sum += weight.weight * of_element[weight.element];
        return sum;
    }

  private:
    std::uint32_t elements_;
    std::shared_ptr<const FieldRows> rows_;  // null: one each
};

}  // namespace afferent
