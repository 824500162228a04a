#include "afferent/encoders/element_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

double square(double x) { return x * x; }

double square_distance(const Position& a, const Position& b) {
    return square(a.x_mm - b.x_mm) + square(a.y_mm - b.y_mm);
}

// The place of the i-th of n points in the middles of n equal parts of a stretch around 0.
double middle(std::int64_t i, std::int64_t n, double part) {
    return (static_cast<double>(i) - static_cast<double>(n - 1) / 2) * part;
}

}  // namespace

ElementGrid::ElementGrid(const Outline& outline, double pitch_mm, std::uint32_t most) : pitch_mm_(pitch_mm) {
    const double columns = std::max(1.0, std::round(outline.width_mm / pitch_mm));
    const double rows = std::max(1.0, std::round(outline.height_mm / pitch_mm));
    require(columns * rows <= most, "pitch_mm",
            ("so large that the outline has at most " + std::to_string(most) + " cells").c_str(), pitch_mm);
    columns_ = static_cast<std::int64_t>(columns);
    const auto row_count = static_cast<std::int64_t>(rows);
    row_begins_.push_back(0);
    for (std::int64_t row = 0; row < row_count; ++row) {
        first_columns_.push_back(0);
        for (std::int64_t column = 0; column < columns_; ++column) {
            const Position place{middle(column, columns_, pitch_mm), middle(row, row_count, pitch_mm)};
            if (!outline.contains(place)) continue;
            if (elements() == row_begins_.back()) first_columns_.back() = column;
            places_.push_back(place);
        }
        row_begins_.push_back(elements());
    }
    require(!places_.empty(), "pitch_mm", "so small that a cell's centre lies within the outline", pitch_mm);
}

std::uint32_t ElementGrid::element_at(std::int64_t column, std::int64_t row) const noexcept {
    if (row < 0 || row >= rows()) return none;
    const auto index = static_cast<std::size_t>(row);
    const std::int64_t in_row = column - first_columns_[index];
    if (in_row < 0 || in_row >= row_begins_[index + 1] - row_begins_[index]) return none;
    return row_begins_[index] + static_cast<std::uint32_t>(in_row);
}

double ElementGrid::row_y_mm(std::uint32_t row) const noexcept { return middle(row, rows(), pitch_mm_); }

std::uint32_t ElementGrid::nearest(const Position& place) const noexcept {
    std::uint32_t best = 0;
    double smallest = std::numeric_limits<double>::infinity();
    for (std::uint32_t j = 0; j < rows(); ++j) {
        if (square(row_y_mm(j) - place.y_mm) >= smallest || row(j).empty()) continue;
        // The nearest of its row.
        const double column = std::round(place.x_mm / pitch_mm_ + static_cast<double>(columns_ - 1) / 2);
        const double in_row = std::clamp(column - static_cast<double>(first_columns_[j]), 0.0,
                                         static_cast<double>(row(j).size() - 1));
        const std::uint32_t element = row_begins_[j] + static_cast<std::uint32_t>(in_row);
        const double distance = square_distance(places_[element], place);
        if (distance >= smallest) continue;
        smallest = distance;
        best = element;
    }
    return best;
}

void ElementGrid::add_gaussian_field(const Position& centre, double sd_mm, FieldRows& fields) const {
    // In cells, as far as columns and rows go.
    const double x = centre.x_mm / pitch_mm_ + static_cast<double>(columns_ - 1) / 2;
    const double y = centre.y_mm / pitch_mm_ + (static_cast<double>(rows()) - 1) / 2;
    const double sd = sd_mm / pitch_mm_;
    const double smallest = square(x - std::round(x)) + square(y - std::round(y));
    const double largest = std::max(square(3 * sd), smallest);
    const double reach = std::sqrt(largest);
    double sum = 0;
    const auto first_row = static_cast<std::int64_t>(std::ceil(y - reach));
    const auto first_column = static_cast<std::int64_t>(std::ceil(x - reach));
    for (std::int64_t j = first_row; static_cast<double>(j) <= y + reach; ++j)
        for (std::int64_t i = first_column; static_cast<double>(i) <= x + reach; ++i) {
            const double distance = square(static_cast<double>(i) - x) + square(static_cast<double>(j) - y);
            if (distance > largest) continue;
            // Relative to the nearest cell, whose weight would vanish where the pitch is many deviations.
            const double weight = std::exp((smallest - distance) / (2 * sd * sd));
            sum += weight;
            const std::uint32_t element = element_at(i, j);
            if (element != none && weight > 0) fields.add({element, weight});
        }
    // At the border, the cells in reach may all lie outside the outline.
    if (fields.last().empty()) fields.add({nearest(centre), sum});
    for (FieldWeight& weight : fields.last()) weight.weight /= sum * square(pitch_mm_);
    fields.end_row();
}

namespace {

// A lattice over the rectangle around an outline.
struct Lattice {
    std::int64_t columns;
    std::int64_t rows;

    double x_spacing(const Outline& outline) const { return outline.width_mm / static_cast<double>(columns); }
    double y_spacing(const Outline& outline) const { return outline.height_mm / static_cast<double>(rows); }

    // use(place) for each place within the outline, row by row.
    template <class Use>
    void for_each(const Outline& outline, Use&& use) const {
        for (std::int64_t j = 0; j < rows; ++j)
            for (std::int64_t i = 0; i < columns; ++i) {
                const Position place{middle(i, columns, x_spacing(outline)),
                                     middle(j, rows, y_spacing(outline))};
                if (outline.contains(place)) use(place);
            }
    }
};

// Nearly square, and of those the nearest to the wanted number of places within the outline.
Lattice lattice_of(const Outline& outline, double per_cm2, std::uint32_t most) {
    const double in_rectangle = outline.width_mm * outline.height_mm * per_cm2 / 100;
    const double columns =
        std::max(1.0, std::round(std::sqrt(in_rectangle * outline.width_mm / outline.height_mm)));
    const double rows = std::max(1.0, std::round(in_rectangle / columns));
    require((columns + 1) * (rows + 1) <= 2.0 * most, "per_cm2",
            ("so low that the outline has at most " + std::to_string(most) + " afferents").c_str(), per_cm2);
    const double wanted = outline.area_mm2() * per_cm2 / 100;
    Lattice best{1, 1};
    double smallest_miss = HUGE_VAL;
    for (const int more_columns : {0, -1, 1})
        for (const int more_rows : {0, -1, 1}) {
            const Lattice tried{std::max<std::int64_t>(1, static_cast<std::int64_t>(columns) + more_columns),
                                std::max<std::int64_t>(1, static_cast<std::int64_t>(rows) + more_rows)};
            double count = 0;
            tried.for_each(outline, [&](const Position&) { ++count; });
            if (count < 1 || !(std::abs(count - wanted) < smallest_miss)) continue;
            smallest_miss = std::abs(count - wanted);
            best = tried;
        }
    return best;
}

}  // namespace

std::vector<Position> jittered_lattice(const Outline& outline, double per_cm2, double jitter,
                                       std::uint32_t most,
                                       const std::function<double(std::uint32_t, std::uint32_t)>& uniform) {
    const Lattice lattice = lattice_of(outline, per_cm2, most);
    const double x_jitter_mm = jitter * lattice.x_spacing(outline);
    const double y_jitter_mm = jitter * lattice.y_spacing(outline);
    std::vector<Position> places;
    lattice.for_each(outline, [&](const Position& place) {
        const auto index = static_cast<std::uint32_t>(places.size());
        const Position moved{place.x_mm + x_jitter_mm * (uniform(index, 0) - 0.5),
                             place.y_mm + y_jitter_mm * (uniform(index, 1) - 0.5)};
        places.push_back(outline.contains(moved) ? moved : place);
    });
    require(places.size() <= most, "per_cm2",
            "so low that the outline holds no more afferents than there may be", per_cm2);
    return places;
}

}  // namespace afferent
