#include "afferent/io/files/scan_file.hpp"

#include <vector>

#include "afferent/io/files/hdf5.hpp"
#include "afferent/io/files/scan_set.hpp"

namespace afferent {
namespace {

Error unreadable(std::string text) { return {Error::Kind::malformed, std::move(text)}; }

Result<std::vector<double>> times_of(const hdf5::File& file, const std::string& dataset,
                                     const hdf5::Numbers& scans) {
    std::vector<double> times(scans.dimensions[0]);
    if (const auto rate_hz = hdf5::number_attribute(scans.data.id(), "rate_hz")) {
        if (!(*rate_hz > 0)) return unreadable(dataset + " has an attribute rate_hz that is not above 0");
        for (std::size_t i = 0; i < times.size(); ++i) times[i] = static_cast<double>(i) / *rate_hz;
        return times;
    }
    const std::string beside = dataset.substr(0, dataset.rfind('/') + 1) + "time_s";
    const auto column = hdf5::open_numbers(file.id(), beside, 1, 1, ScanSet::most_values);
    if (!column)
        return unreadable(dataset + " has no attribute rate_hz, and " + column.error().text +
                          ": the scans have no times");
    if (column.value().dimensions[0] != times.size())
        return unreadable(beside + " has " + std::to_string(column.value().dimensions[0]) + " times, and " +
                          dataset + " has " + std::to_string(times.size()) + " scans");
    for (std::size_t i = 0; i < times.size(); ++i) {
        AFFERENT_TRY(column.value().read(i, std::span(times).subspan(i, 1)));
    }
    return times;
}

}  // namespace

Result<void> read_scans(const std::filesystem::path& file, const std::string& dataset,
                        const std::function<void(std::span<const std::byte>)>& say) {
    const hdf5::Quiet quiet;
    AFFERENT_TRY(opened, hdf5::open_file(file));
    AFFERENT_TRY(scans, hdf5::open_numbers(opened.id(), dataset, 2, 3, ScanSet::most_values));
    ScanSet::Head head;
    head.scans = scans.dimensions[0];
    head.is_image = scans.dimensions.size() == 3 ? 1 : 0;
    if (head.is_image) head.rows = scans.dimensions[1];
    head.columns = scans.dimensions.back();
    AFFERENT_TRY(times, times_of(opened, dataset, scans));
    say(std::as_bytes(std::span(&head, 1)));
    say(std::as_bytes(std::span(times)));
    std::vector<double> values(head.rows * head.columns);
    for (hsize_t i = 0; i < head.scans; ++i) {
        AFFERENT_TRY(scans.read(i, values));
        say(std::as_bytes(std::span(values)));
    }
    return success();
}

}  // namespace afferent
