// The raster of a view: events counted in cells of time and of neighbouring addresses, so that a second of it
// is as large for a million afferents as for two hundred.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "afferent/runtime/event.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// Which row each address is in, and how long a bin is. Every patch has rows of its own; only where there are
// more patches than rows do neighbours share one.
class RasterLayout {
  public:
    static constexpr std::uint32_t most_rows = 200;
    static constexpr std::uint32_t most_cells_per_second = 10'000;

    struct Patch {
        std::string name;
        std::uint32_t afferents;
        std::uint32_t first_row;
        std::uint32_t rows;
    };

    // Patches have the addresses from 0 on, one after another.
    struct Afferents {
        std::string name;
        std::uint32_t count;
    };
    explicit RasterLayout(const std::vector<Afferents>& patches);
    explicit RasterLayout(const Plan& plan);

    const std::vector<Patch>& patches() const noexcept { return patches_; }
    std::uint32_t rows() const noexcept { return rows_; }
    // 1, 2, 5, 10 or 20 ms.
    Duration bin() const noexcept { return bin_; }
    std::uint32_t addresses() const noexcept { return static_cast<std::uint32_t>(row_.size()); }
    std::uint32_t row(Address address) const noexcept { return row_[address]; }

  private:
    std::vector<Patch> patches_;
    std::vector<std::uint8_t> row_;  // of each address
    std::uint32_t rows_ = 0;
    Duration bin_{};
};

// Counts of consecutive bins: bin after bin, row after row.
struct RasterRun {
    std::int64_t first_bin = 0;
    std::vector<std::uint32_t> counts;
};

// Counts the events of a short span of time at once, and passes the counts on once the span is over.
class RasterBins {
  public:
    static constexpr Duration span = std::chrono::milliseconds(40);

    explicit RasterBins(const RasterLayout& layout);

    // Events come in the order of time. One that is late counts in the bin that is being counted, so that
    // none is lost; those at addresses that do not exist are passed over. `pass` takes a RasterRun.
    template <class Pass>
    void add(std::span<const Event> events, const Pass& pass) {
        for (const Event& event : events) {
            if (event.time >= end_) open(event.time, pass);
            if (event.address >= layout_.addresses()) continue;
            while (event.time >= bin_end_) next_bin();
            ++run_.counts[column_ + layout_.row(event.address)];
        }
    }
    // Nothing is to come before this time. Spans that are over are passed on, empty ones as well.
    template <class Pass>
    void until(TimePoint time, const Pass& pass) {
        if (time >= end_) open(time, pass);
    }
    // Passes on what has been counted, and begins again.
    template <class Pass>
    void finish(const Pass& pass) {
        if (counting_) pass(run_);
        end_ = TimePoint::min();
        counting_ = false;
    }

    // After a pause as long as this it begins where the next event is: what lies between is left out.
    static constexpr Duration longest_silence = std::chrono::seconds(2);

  private:
    template <class Pass>
    void open(TimePoint time, const Pass& pass) {
        if (counting_ && time - end_ < longest_silence) {
            while (time >= end_) {
                pass(run_);
                begin(end_);
            }
            return;
        }
        finish(pass);
        begin(time);
    }
    void begin(TimePoint time);
    void next_bin() noexcept {
        column_ += layout_.rows();
        bin_end_ += layout_.bin();
    }

    const RasterLayout& layout_;
    RasterRun run_;
    bool counting_ = false;
    TimePoint end_ = TimePoint::min();  // of the span
    TimePoint bin_end_ = TimePoint::min();
    std::size_t column_ = 0;  // of the bin that is counted, in run_.counts
};

}  // namespace afferent
