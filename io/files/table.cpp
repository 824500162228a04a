#include "afferent/io/files/table.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>
#include <utility>

#include "afferent/io/files/table_reader.hpp"

namespace afferent {

std::variant<Table, TableError> read_table(const std::filesystem::path& file,
                                           std::vector<std::string> wanted) {
    const auto system_error = [&](const char* what) {
        return TableError{file.string(), 0, what + std::generic_category().message(errno)};
    };
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(file.c_str(), "rb"), std::fclose);
    if (!in) return system_error("cannot be opened: ");

    TableReader reader(file.string(), std::move(wanted));
    Table table{.file = file.string(), .columns = {}, .times = {}, .values = {}};
    const auto keep = [&table](const TableRow& row) {
        table.times.push_back(row.time);
        table.values.insert(table.values.end(), row.values.begin(), row.values.end());
    };
    std::array<char, 65536> bytes;
    while (const std::size_t size = std::fread(bytes.data(), 1, bytes.size(), in.get()))
        if (auto error = reader.feed({bytes.data(), size}, keep)) return std::move(*error);
    if (std::ferror(in.get()) != 0) return system_error("cannot be read: ");
    if (auto error = reader.finish()) return std::move(*error);
    table.columns = reader.columns();
    return table;
}

}  // namespace afferent
