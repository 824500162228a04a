#include "afferent/io/files/scan_set.hpp"

#include <cmath>
#include <cstring>

namespace afferent {
namespace {

Error malformed(const char* what) { return {Error::Kind::malformed, what}; }

}  // namespace

Result<ScanSet> ScanSet::of(std::vector<std::byte> bytes) {
    ScanSet set;
    set.bytes_ = std::move(bytes);
    if (set.bytes_.size() < sizeof(Head)) return malformed("these are no scans");
    std::memcpy(&set.head_, set.bytes_.data(), sizeof(Head));
    const Head& head = set.head_;
    const auto small = [](std::uint64_t count) { return count > 0 && count <= most_values; };
    if (head.format != Head().format || !small(head.scans) || !small(head.rows) || !small(head.columns) ||
        head.rows > most_values / head.columns || head.scans > most_values / (head.rows * head.columns))
        return malformed("these are no scans, or too many");
    const std::uint64_t numbers = head.scans * (head.rows * head.columns + 1);
    if (set.bytes_.size() != sizeof(Head) + numbers * sizeof(double))
        return malformed("these are not all scans");
    double before_s = -1;
    for (std::size_t i = 0; i < set.scans(); ++i) {
        // Not so for NaN, either.
        if (!(set.time_s(i) > before_s && set.time_s(i) >= 0 && set.time_s(i) <= 1e9))
            return malformed("the times of its scans must rise from 0 on");
        before_s = set.time_s(i);
    }
    return set;
}

Result<ScanSet> ScanSet::of(std::span<const double> times_s, std::size_t rows, std::size_t columns,
                            bool is_image, std::span<const double> values) {
    const Head head{.scans = times_s.size(), .rows = rows, .columns = columns, .is_image = is_image};
    std::vector<std::byte> bytes(sizeof head + times_s.size_bytes() + values.size_bytes());
    std::memcpy(bytes.data(), &head, sizeof head);
    if (!times_s.empty()) std::memcpy(bytes.data() + sizeof head, times_s.data(), times_s.size_bytes());
    if (!values.empty())
        std::memcpy(bytes.data() + sizeof head + times_s.size_bytes(), values.data(), values.size_bytes());
    return of(std::move(bytes));
}

double ScanSet::number(std::size_t index) const noexcept {
    double value = 0;
    std::memcpy(&value, bytes_.data() + sizeof(Head) + index * sizeof value, sizeof value);
    return value;
}

void ScanSet::copy(std::size_t scan, std::span<double> values) const noexcept {
    const std::size_t first = scans() + scan * values.size();
    std::memcpy(values.data(), bytes_.data() + sizeof(Head) + first * sizeof(double), values.size_bytes());
}

}  // namespace afferent
