// From the scans of a patch to the drives of the afferents that read it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "afferent/encoders/encoder.hpp"
#include "afferent/encoders/receptive_fields.hpp"
#include "afferent/runtime/scan.hpp"

namespace afferent {

// The scans of one time, from the first on.
inline std::span<const Scan> simultaneous(std::span<const Scan> scans) {
    const auto later = std::find_if(scans.begin(), scans.end(),
                                    [&](const Scan& scan) { return scan.time != scans.front().time; });
    return {scans.begin(), later};
}

// The afferents first, first + 1, ... of a patch. An afferent gets a new drive when an element that it reads
// is sampled. The memory is that of the elements between the first and the last that they read.
template <Encoder E>
class FieldEncoder {
  public:
    // `first_element` is the address of the patch's first element.
    FieldEncoder(E encoder, const ReceptiveFields& fields, Address first_element, std::uint32_t first,
                 std::uint32_t count)
        : encoder_(std::move(encoder)),
          count_(count),
          states_(states(count)),
          fields_(fields),
          first_(first) {
        const ElementRange read = fields.read_by(first, count);
        begin_ = read.begin;
        first_element_ = first_element + begin_;
        if (fields.is_one_each()) return;
        forces_n_.resize(read.end - read.begin);
        find_readers();
        touched_.reserve(count);
        is_touched_.resize(count);
    }

    std::uint32_t size() const noexcept { return count_; }

    // Scans of one time. set_drive(i, drive_mv) is called once for each afferent that reads one of their
    // elements.
    template <class SetDrive>
    void take(std::span<const Scan> scans, SetDrive&& set_drive) {
        if (fields_.is_one_each()) {
            // A copy, which the drives that are stored cannot change: so its loop can be in vectors.
            const E encoder = encoder_;
            for (const Scan& scan : scans)
                for_each(scan, size(), [&](std::size_t i, double force_n) {
                    set_drive(i, encoder.drive_mv(state(i), scan.time, force_n));
                });
            return;
        }
        for (const Scan& scan : scans)
            for_each(scan, static_cast<std::uint32_t>(forces_n_.size()),
                     [&](std::size_t element, double force_n) { touch(element, force_n); });
        for (const std::uint32_t i : touched_) {
            is_touched_[i] = false;
            set_drive(i, encoder_.drive_mv(state(i), scans.front().time, felt_n(i)));
        }
        touched_.clear();
    }

    // The drive of untouched skin, from the beginning: the bias.
    template <class SetDrive>
    void reset(SetDrive&& set_drive) {
        std::fill(states_.begin(), states_.end(), typename E::State{});
        std::fill(forces_n_.begin(), forces_n_.end(), 0.0);
        typename E::State untouched;
        const double drive_mv = encoder_.drive_mv(untouched, scene_start, 0);
        for (std::uint32_t i = 0; i < size(); ++i) set_drive(i, drive_mv);
    }

    // Besides the object itself, with the rows of these afferents.
    std::size_t bytes() const noexcept {
        return states_.size() * sizeof(typename E::State) + forces_n_.size() * sizeof(double) +
               readers_.size() * (sizeof(FieldWeight) + sizeof(std::uint32_t)) +
               (reader_begins_.size() + touched_.capacity()) * sizeof(std::uint32_t) + is_touched_.size();
    }
    // bytes() of one that is yet to be built.
    static std::size_t size_of(const ReceptiveFields& fields, std::uint32_t first, std::uint32_t count) {
        const std::size_t state_bytes = states(count) * sizeof(typename E::State);
        if (fields.is_one_each()) return state_bytes;
        const ElementRange read = fields.read_by(first, count);
        const std::size_t elements = read.end - read.begin;
        std::size_t weights = 0;
        for (std::uint32_t i = first; i < first + count; ++i) weights += fields.row(i).size();
        return state_bytes + elements * sizeof(double) +
               weights * (sizeof(FieldWeight) + sizeof(std::uint32_t)) +
               (elements + 1 + count) * sizeof(std::uint32_t) + count * sizeof(char);
    }

  private:
    // A state that holds nothing is not stored for each.
    static constexpr bool has_state = !std::is_empty_v<typename E::State>;
    static constexpr std::size_t states(std::uint32_t count) { return has_state ? count : 1; }
    typename E::State& state(std::size_t i) noexcept { return states_[has_state ? i : 0]; }

    // use(index, force_n) for the samples of a scan that belong to so many elements from the first on.
    template <class Use>
    void for_each(const Scan& scan, std::uint32_t elements, Use&& use) const {
        const Address begin = std::max(scan.first, first_element_);
        const Address end =
            std::min(scan.first + static_cast<Address>(scan.forces_n.size()), first_element_ + elements);
        if (begin >= end) return;
        const double* const forces_n = scan.forces_n.data() + (begin - scan.first);
        const std::size_t first = begin - first_element_;
        const std::size_t count = end - begin;
        for (std::size_t k = 0; k < count; ++k) use(first + k, forces_n[k]);
    }

    // By element: the afferents that read it. Throws std::out_of_range where a row reads beyond read_by().
    void find_readers() {
        reader_begins_.assign(forces_n_.size() + 1, 0);
        for (std::uint32_t i = 0; i < size(); ++i)
            for (const auto& weight : fields_.row(first_ + i))
                ++reader_begins_.at(std::size_t{weight.element} - begin_ + 1);
        std::partial_sum(reader_begins_.begin(), reader_begins_.end(), reader_begins_.begin());
        readers_.resize(reader_begins_.back());
        std::vector<std::uint32_t> next(reader_begins_.begin(), reader_begins_.end() - 1);
        for (std::uint32_t i = 0; i < size(); ++i)
            for (const auto& weight : fields_.row(first_ + i)) readers_[next[weight.element - begin_]++] = i;
    }

    void touch(std::size_t element, double force_n) {
        forces_n_[element] = force_n;
        for (std::uint32_t k = reader_begins_[element]; k < reader_begins_[element + 1]; ++k)
            if (!is_touched_[readers_[k]]) {
                is_touched_[readers_[k]] = true;
                touched_.push_back(readers_[k]);
            }
    }

    double felt_n(std::uint32_t i) const noexcept {
        double sum_n = 0;
        for (const auto& weight : fields_.row(first_ + i))
            sum_n += weight.weight * forces_n_[weight.element - begin_];
        return sum_n;
    }

    E encoder_;
    std::uint32_t count_;  // of afferents
    std::vector<typename E::State> states_;
    ReceptiveFields fields_;
    std::uint32_t first_;    // afferent of the patch
    std::uint32_t begin_;    // the first element of the patch that they read
    Address first_element_;  // its address

    // Where there are rows of weights. Elements are counted from begin_.
    std::vector<double> forces_n_;  // last sampled
    std::vector<std::uint32_t> reader_begins_;
    std::vector<std::uint32_t> readers_;
    std::vector<std::uint32_t> touched_;
    std::vector<char> is_touched_;
};

}  // namespace afferent
