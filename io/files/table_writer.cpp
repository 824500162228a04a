#include "afferent/io/files/table_writer.hpp"

#include <array>
#include <cassert>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <string>
#include <system_error>
#include <utility>

namespace afferent {
namespace {

// Large enough for any number in any of the forms below, but for a huge one with many decimals.
using Text = std::array<char, 400>;

template <class... How>
std::string_view to_text(Text& text, How... how) {
    const auto [end, failure] = std::to_chars(text.data(), text.data() + text.size(), how...);
    assert(failure == std::errc());
    return {text.data(), end};
}

constexpr std::chrono::milliseconds patience{1000};

bool is_named_pipe(const std::filesystem::path& file) {
    std::error_code ignored;
    return std::filesystem::is_fifo(file, ignored);
}

std::filesystem::path written_first(const std::filesystem::path& file) {
    std::error_code ignored;
    const auto status = std::filesystem::status(file, ignored);
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) return file;
    return file.string() + ".part";
}

}  // namespace

TableWriter::TableWriter(std::filesystem::path file, std::span<const std::string_view> columns,
                         FullPipe full_pipe)
    : file_(std::move(file)),
      part_(written_first(file_)),
      is_pipe_(full_pipe == FullPipe::lose_rows && is_named_pipe(file_)),
      columns_(columns.size()) {
    if (!is_pipe_) {
        out_.reset(std::fopen(part_.c_str(), "wb"));
        if (!out_) fail("cannot be opened for writing");
    }
    for (const std::string_view column : columns) put_cell(column);
    end_row();
}

void TableWriter::cell(TimePoint time) {
    const std::int64_t ns = time.time_since_epoch().count();
    constexpr std::uint64_t ns_per_s = 1'000'000'000;
    // The magnitude without overflow, for every value.
    const std::uint64_t magnitude =
        ns < 0 ? 0 - static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
    Text digits;
    // The leading 1 keeps the zeros after the point.
    const std::string_view decimals = to_text(digits, ns_per_s + magnitude % ns_per_s).substr(1);
    Text whole;
    std::string text = ns < 0 ? "-" : "";
    text += to_text(whole, magnitude / ns_per_s);
    text += '.';
    text += decimals;
    put_cell(text);
}

void TableWriter::cell(std::uint64_t count) {
    Text text;
    put_cell(to_text(text, count));
}

void TableWriter::cell(double value) {
    assert(std::isfinite(value));
    Text text;
    put_cell(to_text(text, value));
}

void TableWriter::cell(double value, int decimals) {
    assert(std::isfinite(value) && decimals >= 0 && decimals <= 18);
    Text text;
    put_cell(to_text(text, value, std::chars_format::fixed, decimals));
}

void TableWriter::text(std::string_view text) {
    if (text.find_first_of(",\"\r\n") == std::string_view::npos) return put_cell(text);
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    put_cell(quoted + '"');
}

void TableWriter::no_value() { put_cell(""); }

void TableWriter::end_row() {
    assert(cells_ == columns_);
    cells_ = 0;
    put("\n");
    if (!is_pipe_ || error_) return;
    if (pipe_) {
        pipe_->put(row_);
    } else {
        // The first row of a pipe is the head.
        pipe_ = std::make_unique<RowPipe>(file_, row_);
        errno = pipe_->error();
        if (errno != 0) fail("cannot be opened for writing");
    }
    row_.clear();
}

std::optional<TableError> TableWriter::close() {
    if (out_ && std::fclose(out_.release()) != 0) fail("cannot be written");
    if (pipe_ && !pipe_->finish(patience) && !error_)
        error_ = TableError{file_.string(), 0, "has taken nothing for a second"};
    if (error_ || part_ == file_) return error_;
    std::error_code failure;
    std::filesystem::rename(part_, file_, failure);
    if (failure)
        error_ = TableError{file_.string(), 0,
                            "cannot be renamed from " + part_.string() + ": " + failure.message()};
    return error_;
}

void TableWriter::put_cell(std::string_view text) {
    if (cells_++ > 0) put(",");
    put(text);
}

void TableWriter::put(std::string_view bytes) {
    if (error_) return;
    if (is_pipe_) {
        row_ += bytes;
        return;
    }
    if (std::fwrite(bytes.data(), 1, bytes.size(), out_.get()) != bytes.size()) fail("cannot be written");
}

void TableWriter::fail(std::string_view what) {
    const int code = errno;
    if (!error_)
        error_ =
            TableError{file_.string(), 0, std::string(what) + ": " + std::generic_category().message(code)};
}

}  // namespace afferent
