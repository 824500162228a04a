#include "afferent/io/files/table.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include "afferent/io/files/input_file.hpp"
#include "afferent/io/files/table_reader.hpp"

namespace afferent {

std::variant<Table, TableError> read_table(const std::filesystem::path& file,
                                           std::vector<std::string> wanted) {
    auto in = open_input(file);
    // The message begins with the file's name, as a TableError's does.
    if (!in) return TableError{file.string(), 0, in.error().text.substr(file.string().size() + 2)};

    TableReader reader(file.string(), std::move(wanted));
    Table table{.file = file.string(), .columns = {}, .times = {}, .values = {}};
    const auto keep = [&table](const TableRow& row) {
        table.times.push_back(row.time);
        table.values.insert(table.values.end(), row.values.begin(), row.values.end());
    };
    std::array<char, 65536> bytes;
    while (const std::size_t size = std::fread(bytes.data(), 1, bytes.size(), in.value().get()))
        if (auto error = reader.feed({bytes.data(), size}, keep)) return std::move(*error);
    if (std::ferror(in.value().get()) != 0)
        return TableError{file.string(), 0, "cannot be read: " + std::generic_category().message(errno)};
    if (auto error = reader.finish()) return std::move(*error);
    table.columns = reader.columns();
    return table;
}

}  // namespace afferent
