// The hop that the sensors' samples take to the coprocessor: a radio that connects every so often.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "afferent/scene/plan.hpp"

namespace afferent {

// At each of its connections the radio takes the newest sample of every element, and hands it over at the
// next: after one to two intervals, as in the paper's Bluetooth hop. Samples between two connections are
// superseded by the last of them. The phase of the connections differs from presentation to presentation. An
// interval of 0: there is no such hop, and samples are there at once.
class SampleRadio {
  public:
    SampleRadio(Duration interval, std::uint32_t elements, std::uint64_t seed);

    bool in_use() const noexcept { return interval_ > Duration::zero(); }
    // Starts the presentation of that number.
    void begin(std::uint32_t number);

    void take(Address first, std::span<const double> forces_n);
    TimePoint next_connection() const noexcept { return next_; }
    // The forces on all elements that the next connection hands over; nothing where it has none. Valid until
    // take().
    std::optional<std::span<const double>> connect();

  private:
    Duration interval_;
    std::uint64_t seed_;
    TimePoint next_{};
    std::vector<double> newest_n_;
    std::vector<double> under_way_n_;
    std::vector<double> handed_over_n_;
    bool has_newest_ = false;
    bool has_under_way_ = false;
};

}  // namespace afferent
