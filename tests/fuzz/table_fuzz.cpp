// A table of any bytes, cut anywhere: the same rows, the same form and the same error, times that rise from 0
// on, numbers that are finite.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "afferent/io/files/table_reader.hpp"
#include "fuzz.hpp"

namespace afferent {
namespace {

struct Read {
    std::vector<double> values;
    std::size_t rows = 0;
    bool refused = false;
    std::vector<std::string> form;
};

// The first byte says how a piece is cut, and whether there is anything that the table is not asked for.
TableOptions asked(std::uint8_t how) {
    TableOptions options;
    if ((how & 0x40U) != 0) options.rate_hz = 250;
    if ((how & 0x80U) != 0) options.begin = 3ms;
    return options;
}

Read read(std::string_view bytes, std::size_t piece, std::uint8_t how) {
    TableReader reader("table", asked(how));
    Read found;
    std::optional<TimePoint> last;
    const auto on_row = [&](const TableRow& row) {
        must(!last || row.time > *last);
        must(row.time >= scene_start);
        last = row.time;
        for (const double value : row.values) {
            must(std::isfinite(value));
            found.values.push_back(value);
        }
        ++found.rows;
    };
    for (; !bytes.empty() && !found.refused; bytes.remove_prefix(std::min(piece, bytes.size())))
        found.refused = reader.feed(bytes.substr(0, piece), on_row).has_value();
    if (!found.refused) found.refused = reader.finish(on_row).has_value();
    found.form = reader.format().sentences();
    return found;
}

}  // namespace
}  // namespace afferent

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    if (size == 0) return 0;
    const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
    const Read cut = read(bytes, 1U + data[0], data[0]);
    const Read whole = read(bytes, size, data[0]);
    must(cut.refused == whole.refused && cut.rows == whole.rows && cut.values == whole.values &&
         cut.form == whole.form);
    return 0;
}
