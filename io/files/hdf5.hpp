// The part of HDF5's C interface that we need: handles that close themselves, and columns that are checked
// before memory is allocated for them. Only the sources of hdf5_files include this.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "afferent/runtime/result.hpp"

namespace afferent::hdf5 {

// Owns an HDF5 object of any kind. Empty if the id is negative.
template <herr_t (*close_it)(hid_t)>
class Handle {
  public:
    Handle() = default;
    explicit Handle(hid_t id) noexcept : id_(id) {}
    Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
    Handle& operator=(Handle&& other) noexcept {
        std::swap(id_, other.id_);
        return *this;
    }
    ~Handle() { close(); }

    explicit operator bool() const noexcept { return id_ >= 0; }
    hid_t id() const noexcept { return id_; }
    // True if everything has been written.
    bool close() noexcept { return id_ < 0 || close_it(std::exchange(id_, H5I_INVALID_HID)) >= 0; }

  private:
    hid_t id_ = H5I_INVALID_HID;
};

using File = Handle<H5Fclose>;
using Group = Handle<H5Gclose>;
using Dataset = Handle<H5Dclose>;
using Space = Handle<H5Sclose>;
using Type = Handle<H5Tclose>;
using Attribute = Handle<H5Aclose>;
using Properties = Handle<H5Pclose>;

// HDF5 prints its errors unless it is told not to; we report our own.
class Quiet {
  public:
    Quiet();
    ~Quiet();
    Quiet(const Quiet&) = delete;
    Quiet& operator=(const Quiet&) = delete;

  private:
    H5E_auto2_t print_ = nullptr;
    void* to_ = nullptr;
};

// Columns of more rows are refused, whatever their file says.
inline constexpr std::uint64_t most_rows = std::uint64_t{1} << 28;

// --- Reading. Errors are `malformed` and name the object. Only hard links are followed.

Result<File> open_file(const std::filesystem::path& file);
Result<Group> open_group(hid_t parent, const std::string& name);

// Columns of one dimension. Integers must not be negative. A column may not claim more than its bytes in the
// file could hold, compressed as well as deflate can.
Result<std::vector<std::uint64_t>> read_whole_numbers(hid_t group, const std::string& name);
Result<std::vector<double>> read_numbers(hid_t group, const std::string& name);

// A dataset of numbers, by the path of groups to it, to be read one index of its first dimension at a time.
struct Numbers {
    Dataset data;
    Space space;
    std::vector<hsize_t> dimensions;

    // The values from this index of the first dimension on, as many as there is room for: whole rows, the
    // last dimension fastest. Of two dimensions with a single row that row is read, from this place in it on.
    Result<void> read(hsize_t first, std::span<double> values) const;
};
// Of so many dimensions, and of at most so many numbers in all.
Result<Numbers> open_numbers(hid_t file, const std::string& path, std::size_t fewest, std::size_t most,
                             std::uint64_t most_numbers);

// Texts of any length up to 1000 bytes.
Result<std::vector<std::string>> read_texts(hid_t group, const std::string& name);

// The value of an attribute, if it is a number.
std::optional<double> number_attribute(hid_t object, const char* name);
// The text of an attribute, or "" if there is none or it is not a text.
std::string text_attribute(hid_t object, const char* name);

// The names of the datasets of numbers, of one dimension or two, in a group ("run/"; "": the root);
// `malformed` if there are more than `most` members.
Result<std::vector<std::string>> numbers_in(hid_t file, const std::string& group, std::size_t most);

// The names of the groups in a group; `malformed` if there are more than `most`.
Result<std::vector<std::string>> groups_in(hid_t group, std::size_t most);

// --- Writing. False or an empty handle: it failed.

// In memory, because the library cannot close a file on a full disk, and complains at exit. No other file of
// that name may be open.
File create_file(const char* name);
bool save(const File& file, const std::filesystem::path& to);

Dataset write_column(hid_t group, const char* name, std::span<const double> values);
Dataset write_column(hid_t group, const char* name, std::span<const std::uint64_t> values);
Dataset write_column(hid_t group, const char* name, std::span<const std::int64_t> values);
bool write_text(hid_t group, const char* name, const std::string& text);
Dataset write_column(hid_t group, const char* name, const std::vector<std::string>& texts);
bool write_attribute(hid_t object, const char* name, const std::string& text);
bool write_attribute(hid_t object, const char* name, const std::vector<std::string>& texts);
bool write_attribute(hid_t object, const char* name, double value);
bool write_attribute(hid_t object, const char* name, std::span<const std::uint32_t> values, bool scalar);
// A reference to the object at that path in the file.
bool write_reference(hid_t object, const char* name, hid_t file, const char* path);

}  // namespace afferent::hdf5
