#include "afferent/io/files/npz_file.hpp"

#include <zip.h>

#include <algorithm>
#include <array>
#include <bit>
#include <boost/endian/conversion.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <string_view>

#include "afferent/io/files/input_file.hpp"

namespace afferent {
namespace {

constexpr std::size_t longest_npy_header = 1 << 16;
constexpr zip_int64_t most_arrays = 1000;

Error bad_array(const std::string& name, const std::string& text) {
    return {Error::Kind::malformed, "array \"" + name + "\" " + text};
}

struct NpyType {
    char kind;  // f, i, u, b or M
    std::size_t bytes;
    bool big_endian;
};

// What stands before the numbers.
struct NpyHead {
    NpyType type{};
    bool by_columns = false;  // Fortran's order
    std::vector<std::uint64_t> shape;
    std::string date_unit;

    // The array as a table: one row for each index of its first dimension.
    std::uint64_t rows() const { return shape[0]; }
    std::uint64_t columns() const { return shape.size() == 2 ? shape[1] : 1; }
};

// What follows "'key': " in the header, which is a dictionary of Python.
std::string_view value_of(std::string_view header, std::string_view key) {
    const std::size_t at = header.find("'" + std::string(key) + "':");
    if (at == std::string_view::npos) return {};
    std::string_view rest = header.substr(at + key.size() + 3);
    rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
    return rest;
}

Result<NpyHead> parse_npy_header(std::string_view header, const std::string& name) {
    NpyHead head;
    std::string_view type = value_of(header, "descr");
    if (type.starts_with('['))
        return bad_array(name, "is of structures; save each of their fields by itself");
    if (!type.starts_with('\'') || type.size() < 4) return bad_array(name, "has no header that can be read");
    type.remove_prefix(1);
    type = type.substr(0, type.find('\''));
    if (type.find('O') != std::string_view::npos)
        return bad_array(name, "is of Python's objects, which are not read; save it as numbers");
    const std::size_t unit = type.find('[');
    if (unit != std::string_view::npos && type.ends_with(']'))
        head.date_unit = type.substr(unit + 1, type.size() - unit - 2);
    const std::string_view plain = type.substr(0, unit);
    if (plain.size() < 3 || std::string_view("<>|=").find(plain[0]) == std::string_view::npos ||
        std::from_chars(plain.data() + 2, plain.data() + plain.size(), head.type.bytes).ec != std::errc())
        return bad_array(name,
                         "is of the type " + std::string(type.substr(0, 20)) + ", which is not of numbers");
    head.type.kind = plain[1];
    head.type.big_endian = plain[0] == '>';
    const std::size_t bytes = head.type.bytes;
    const bool whole = head.type.kind == 'i' || head.type.kind == 'u';
    const bool known = (head.type.kind == 'f' && (bytes == 2 || bytes == 4 || bytes == 8)) ||
                       (whole && (bytes == 1 || bytes == 2 || bytes == 4 || bytes == 8)) ||
                       (head.type.kind == 'b' && bytes == 1) ||
                       (head.type.kind == 'M' && bytes == 8 && time_unit_called(head.date_unit));
    if (!known)
        return bad_array(name, "is of the type " + std::string(type.substr(0, 20)) + ", which is not read");
    head.by_columns = value_of(header, "fortran_order").starts_with("True");
    std::string_view shape = value_of(header, "shape");
    const std::size_t end = shape.find(')');
    if (!shape.starts_with('(') || end == std::string_view::npos) return bad_array(name, "has no shape");
    shape = shape.substr(1, end - 1);
    while (!shape.empty()) {
        std::uint64_t size = 0;
        const auto [stop, failure] = std::from_chars(shape.data(), shape.data() + shape.size(), size);
        if (failure != std::errc() || size > most_numbers || head.shape.size() == 32)
            return bad_array(name, "has too large a shape, or none");
        head.shape.push_back(size);
        shape.remove_prefix(static_cast<std::size_t>(stop - shape.data()));
        shape.remove_prefix(std::min(shape.find_first_not_of(" ,L"), shape.size()));
    }
    return head;
}

double half_precision(std::uint16_t bits) {
    const int exponent = (bits >> 10U) & 0x1F;
    const double fraction = (bits & 0x3FFU) / 1024.0;
    const double size = exponent == 0      ? std::ldexp(fraction, -14)
                        : exponent == 0x1F ? (fraction == 0 ? HUGE_VAL : std::nan(""))
                                           : std::ldexp(1 + fraction, exponent - 15);
    return (bits & 0x8000U) != 0 ? -size : size;
}

double number_at(const unsigned char* bytes, const NpyType& type) {
    std::array<unsigned char, 8> little{};
    for (std::size_t i = 0; i < type.bytes; ++i) little[i] = bytes[type.big_endian ? type.bytes - 1 - i : i];
    std::uint64_t word = 0;
    std::memcpy(&word, little.data(), sizeof word);
    boost::endian::little_to_native_inplace(word);
    if (type.kind == 'f')
        return type.bytes == 8   ? std::bit_cast<double>(word)
               : type.bytes == 4 ? std::bit_cast<float>(static_cast<std::uint32_t>(word))
                                 : half_precision(static_cast<std::uint16_t>(word));
    if (type.kind == 'u' || type.kind == 'b') return static_cast<double>(word);
    const unsigned unused = 64 - 8 * static_cast<unsigned>(type.bytes);
    return static_cast<double>(static_cast<std::int64_t>(word << unused) >> unused);
}

// Bytes from a file or from a member of an archive; fewer than asked for at the end.
class ByteStream {
  public:
    virtual ~ByteStream() = default;
    virtual std::size_t read(unsigned char* to, std::size_t size) = 0;
};

Result<NpyHead> read_npy_head(ByteStream& stream, const std::string& name) {
    std::array<unsigned char, 12> start{};
    if (stream.read(start.data(), 8) != 8 || std::memcmp(start.data(), "\x93NUMPY", 6) != 0)
        return bad_array(name, "is not in NumPy's format");
    const std::size_t width = start[6] == 1 ? 2 : 4;
    if (stream.read(start.data() + 8, width) != width) return bad_array(name, "is cut off");
    std::size_t size = 0;
    for (std::size_t i = 0; i < width; ++i) size |= static_cast<std::size_t>(start[8 + i]) << (8 * i);
    if (size > longest_npy_header)
        return bad_array(name, "has a header of " + std::to_string(size) + " bytes");
    std::string header(size, '\0');
    if (stream.read(reinterpret_cast<unsigned char*>(header.data()), size) != size)
        return bad_array(name, "is cut off");
    return parse_npy_header(header, name);
}

bool is_table_like(const NpyHead& head) {
    return (head.shape.size() == 1 || head.shape.size() == 2) && head.rows() > 0 && head.columns() > 0 &&
           head.shape[0] <= most_numbers / head.columns();
}

class FileStream final : public ByteStream {
  public:
    explicit FileStream(std::FILE* file) : file_(file) {}
    std::size_t read(unsigned char* to, std::size_t size) override { return std::fread(to, 1, size, file_); }

  private:
    std::FILE* file_;
};

struct CloseZip {
    void operator()(zip_t* archive) const noexcept { zip_discard(archive); }
    void operator()(zip_file_t* file) const noexcept { zip_fclose(file); }
};

class ZipStream final : public ByteStream {
  public:
    ZipStream(zip_t* archive, zip_uint64_t index) : file_(zip_fopen_index(archive, index, 0)) {}
    std::size_t read(unsigned char* to, std::size_t size) override {
        std::size_t done = 0;
        while (file_ && done < size) {
            const zip_int64_t count = zip_fread(file_.get(), to + done, size - done);
            if (count <= 0) break;
            done += static_cast<std::size_t>(count);
        }
        return done;
    }

  private:
    std::unique_ptr<zip_file_t, CloseZip> file_;
};

// The numbers of an array behind its head, row by row.
class NpyNumbers {
  public:
    NpyNumbers(std::unique_ptr<ByteStream> stream, NpyHead head, std::string name)
        : stream_(std::move(stream)), head_(std::move(head)), name_(std::move(name)) {}

    Result<void> read(std::uint64_t first_row, std::span<double> values) {
        if (!head_.by_columns || head_.columns() == 1) return read_next(values);
        // Rows are spread over the whole array.
        if (whole_.empty()) {
            if (head_.rows() > Table::most_values / head_.columns())
                return bad_array(name_,
                                 "is in Fortran's order, and larger than 256 MB; save it in C's order");
            whole_.resize(head_.rows() * head_.columns());
            AFFERENT_TRY(read_next(whole_));
        }
        const std::uint64_t columns = head_.columns();
        for (std::uint64_t i = 0; i < values.size(); ++i)
            values[i] = whole_[i % columns * head_.rows() + first_row + i / columns];
        return success();
    }

  private:
    Result<void> read_next(std::span<double> values) {
        constexpr std::uint64_t at_once = 4096;
        piece_.resize(head_.type.bytes * at_once);
        for (std::uint64_t at = 0; at < values.size();) {
            const std::uint64_t now = std::min<std::uint64_t>(at_once, values.size() - at);
            if (stream_->read(piece_.data(), now * head_.type.bytes) != now * head_.type.bytes)
                return bad_array(name_, "is cut off, or damaged");
            for (std::uint64_t i = 0; i < now; ++i, ++at)
                values[at] = number_at(piece_.data() + i * head_.type.bytes, head_.type);
        }
        return success();
    }

    std::unique_ptr<ByteStream> stream_;
    NpyHead head_;
    std::string name_;
    std::vector<unsigned char> piece_;
    std::vector<double> whole_;
};

bool is_wanted(const std::string& name, const TableOptions& options) {
    return name == options.time_column || std::ranges::find(options.columns, name) != options.columns.end();
}

}  // namespace

Result<void> send_npz(const std::filesystem::path& file, const TableOptions& options, const SendPiece& send) {
    int code = 0;
    const std::unique_ptr<zip_t, CloseZip> archive(zip_open(file.c_str(), ZIP_RDONLY, &code));
    if (!archive) return Error{Error::Kind::malformed, "is not an archive in the format of NPZ"};
    const zip_int64_t entries = zip_get_num_entries(archive.get(), 0);
    if (entries > most_arrays)
        return Error{Error::Kind::malformed, "has more than " + std::to_string(most_arrays) + " arrays"};
    std::vector<NumberArray> arrays;
    for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(std::max<zip_int64_t>(0, entries)); ++i) {
        zip_stat_t status;
        zip_stat_init(&status);
        if (zip_stat_index(archive.get(), i, 0, &status) != 0 || !(status.valid & ZIP_STAT_NAME)) continue;
        std::string name = status.name;
        if (!name.ends_with(".npy")) continue;
        name.resize(name.size() - 4);
        if (name.find('\n') != std::string::npos) continue;
        auto stream = std::make_unique<ZipStream>(archive.get(), i);
        const auto head = read_npy_head(*stream, name);
        if (!head && is_wanted(name, options)) return head.error();
        if (!head || !is_table_like(head.value())) continue;
        const auto numbers = std::make_shared<NpyNumbers>(std::move(stream), head.value(), name);
        // Dates are called after their unit, as other times are.
        if (head.value().type.kind == 'M') name += "_" + head.value().date_unit;
        arrays.push_back({.name = std::move(name),
                          .rows = head.value().rows(),
                          .columns = head.value().columns(),
                          .read = [numbers](std::uint64_t first_row, std::span<double> values) {
                              return numbers->read(first_row, values);
                          }});
    }
    return send_columns(std::move(arrays), options, send);
}

// Its columns have no names but their numbers: each is an array of its own, out of rows that are read
// together.
Result<void> send_npy(const std::filesystem::path& file, const TableOptions& options, const SendPiece& send) {
    const std::string name = file.stem().string();
    AFFERENT_TRY(opened, open_input(file));
    auto stream = std::make_unique<FileStream>(opened.get());
    AFFERENT_TRY(head, read_npy_head(*stream, name));
    if (!is_table_like(head)) return bad_array(name, "has neither one dimension nor two");
    const bool is_row = head.rows() == 1;
    const std::uint64_t rows = is_row ? head.columns() : head.rows();
    const std::uint64_t columns = is_row ? 1 : head.columns();
    NpyNumbers numbers(std::move(stream), head, name);
    std::vector<double> read;
    std::optional<std::uint64_t> read_from;
    std::vector<NumberArray> arrays;
    for (std::uint64_t column = 0; column < columns; ++column)
        arrays.push_back({.name = std::to_string(column + 1),
                          .rows = rows,
                          .columns = 1,
                          .read = [&, column](std::uint64_t first, std::span<double> values) -> Result<void> {
                              if (read_from != first) {
                                  read.resize(values.size() * columns);
                                  AFFERENT_TRY(numbers.read(first, read));
                                  read_from = first;
                              }
                              for (std::size_t i = 0; i < values.size(); ++i)
                                  values[i] = read[i * columns + column];
                              return success();
                          }});
    return send_columns(std::move(arrays), options, send);
}

}  // namespace afferent
