// A table of any bytes, cut anywhere: the same rows and the same error, times that rise, numbers that are
// finite.
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
};

Read read(std::string_view bytes, std::size_t piece) {
    TableReader reader("table");
    Read found;
    std::optional<TimePoint> last;
    const auto on_row = [&](const TableRow& row) {
        must(!last || row.time > *last);
        last = row.time;
        for (const double value : row.values) {
            must(std::isfinite(value));
            found.values.push_back(value);
        }
        ++found.rows;
    };
    for (; !bytes.empty() && !found.refused; bytes.remove_prefix(std::min(piece, bytes.size())))
        found.refused = reader.feed(bytes.substr(0, piece), on_row).has_value();
    if (!found.refused) found.refused = reader.finish().has_value();
    return found;
}

}  // namespace
}  // namespace afferent

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    if (size == 0) return 0;
    const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
    const Read cut = read(bytes, 1U + data[0]);
    const Read whole = read(bytes, size);
    must(cut.refused == whole.refused && cut.rows == whole.rows && cut.values == whole.values);
    return 0;
}
