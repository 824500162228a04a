#include "afferent/io/files/hdf5.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>

namespace afferent::hdf5 {
namespace {

// Deflate cannot compress better than 1032 to 1.
constexpr std::uint64_t best_packing = 1032;
// How many rows are read at once.
constexpr hsize_t piece_rows = hsize_t{1} << 16;

Error malformed(const std::string& name, const char* what) {
    return {Error::Kind::malformed, name + " " + what};
}

// Only hard links: others could lead out of the file, or in circles.
bool has_object(hid_t parent, const std::string& name) {
    H5L_info_t link;
    return H5Lexists(parent, name.c_str(), H5P_DEFAULT) > 0 &&
           H5Lget_info(parent, name.c_str(), &link, H5P_DEFAULT) >= 0 && link.type == H5L_TYPE_HARD;
}

// A dataset whose bytes are in its own file, and which does not claim more of them than there can be.
Result<void> check_storage(const Dataset& data, hid_t type, std::uint64_t numbers, const std::string& name) {
    const Properties properties(H5Dget_create_plist(data.id()));
    if (!properties || H5Pget_external_count(properties.id()) != 0 ||
        H5Pget_layout(properties.id()) == H5D_VIRTUAL)
        return malformed(name, "is in another file");
    const bool packed = H5Pget_nfilters(properties.id()) > 0;
    if (numbers * H5Tget_size(type) >
        (packed ? best_packing : 1) * std::uint64_t{H5Dget_storage_size(data.id())})
        return malformed(name, "claims more rows than the file holds");
    return success();
}

struct Column {
    Dataset data;
    Space space;
    hsize_t rows = 0;
};

Result<Column> open_column(hid_t group, const std::string& name, H5T_class_t wanted) {
    if (!has_object(group, name)) return malformed(name, "is missing");
    Column column{.data = Dataset(H5Dopen2(group, name.c_str(), H5P_DEFAULT)), .space = {}};
    if (!column.data) return malformed(name, "is not a column");
    const Type type(H5Dget_type(column.data.id()));
    if (!type || H5Tget_class(type.id()) != wanted)
        return malformed(name, wanted == H5T_INTEGER ? "must be of whole numbers"
                               : wanted == H5T_FLOAT ? "must be of floating point"
                                                     : "must be of texts");
    column.space = Space(H5Dget_space(column.data.id()));
    if (!column.space || H5Sget_simple_extent_ndims(column.space.id()) != 1 ||
        H5Sget_simple_extent_dims(column.space.id(), &column.rows, nullptr) != 1)
        return malformed(name, "must have one dimension");
    if (column.rows > most_rows) return malformed(name, "has more than 2^28 rows");
    AFFERENT_TRY(check_storage(column.data, type.id(), column.rows, name));
    return column;
}

template <class T>
Result<std::vector<T>> read_column(hid_t group, const std::string& name, H5T_class_t wanted, hid_t type) {
    AFFERENT_TRY(column, open_column(group, name, wanted));
    std::vector<T> values;
    for (hsize_t begin = 0; begin < column.rows;) {
        const hsize_t count = std::min(piece_rows, column.rows - begin);
        values.resize(begin + count);
        const Space piece(H5Screate_simple(1, &count, nullptr));
        if (H5Sselect_hyperslab(column.space.id(), H5S_SELECT_SET, &begin, nullptr, &count, nullptr) < 0 ||
            H5Dread(column.data.id(), type, piece.id(), column.space.id(), H5P_DEFAULT,
                    values.data() + begin) < 0)
            return malformed(name, "cannot be read");
        begin += count;
    }
    return values;
}

Type text_type() {
    Type type(H5Tcopy(H5T_C_S1));
    H5Tset_size(type.id(), H5T_VARIABLE);
    H5Tset_cset(type.id(), H5T_CSET_UTF8);
    return type;
}

Space scalar_space() { return Space(H5Screate(H5S_SCALAR)); }

Space row_space(std::size_t count) {
    const hsize_t rows = count;
    return Space(H5Screate_simple(1, &rows, nullptr));
}

Dataset write_data(hid_t group, const char* name, hid_t file_type, hid_t memory_type, const Space& space,
                   const void* data) {
    Dataset dataset(H5Dcreate2(group, name, file_type, space.id(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    if (dataset && H5Dwrite(dataset.id(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) return {};
    return dataset;
}

bool write_data_attribute(hid_t object, const char* name, hid_t file_type, hid_t memory_type,
                          const Space& space, const void* data) {
    const Attribute attribute(H5Acreate2(object, name, file_type, space.id(), H5P_DEFAULT, H5P_DEFAULT));
    return attribute && H5Awrite(attribute.id(), memory_type, data) >= 0;
}

std::vector<const char*> pointers(const std::vector<std::string>& texts) {
    std::vector<const char*> found;
    for (const std::string& text : texts) found.push_back(text.c_str());
    return found;
}

}  // namespace

Quiet::Quiet() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &to_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Quiet::~Quiet() { H5Eset_auto2(H5E_DEFAULT, print_, to_); }

Result<File> open_file(const std::filesystem::path& file) {
    // Datasets are read in pieces: a chunk that is larger than the cache would be decompressed for each.
    constexpr std::size_t cache_bytes = std::size_t{16} << 20U;
    const Properties access(H5Pcreate(H5P_FILE_ACCESS));
    if (access) H5Pset_cache(access.id(), 0, 521, cache_bytes, 0.75);
    File opened(H5Fopen(file.c_str(), H5F_ACC_RDONLY, access ? access.id() : H5P_DEFAULT));
    if (!opened) return malformed("the file", "is not an HDF5 file, or is cut off");
    return opened;
}

Result<Group> open_group(hid_t parent, const std::string& name) {
    if (!has_object(parent, name)) return malformed(name, "is missing");
    Group group(H5Gopen2(parent, name.c_str(), H5P_DEFAULT));
    if (!group) return malformed(name, "is not a group");
    return group;
}

Result<std::vector<std::uint64_t>> read_whole_numbers(hid_t group, const std::string& name) {
    AFFERENT_TRY(values, read_column<std::int64_t>(group, name, H5T_INTEGER, H5T_NATIVE_INT64));
    // A number beyond 2^63 is read as the largest integer, which is out of range for an address.
    if (std::any_of(values.begin(), values.end(), [](std::int64_t v) { return v < 0; }))
        return malformed(name, "has a negative number");
    return std::vector<std::uint64_t>(values.begin(), values.end());
}

Result<std::vector<double>> read_numbers(hid_t group, const std::string& name) {
    return read_column<double>(group, name, H5T_FLOAT, H5T_NATIVE_DOUBLE);
}

Result<Numbers> open_numbers(hid_t file, const std::string& path, std::size_t fewest, std::size_t most,
                             std::uint64_t most_numbers) {
    std::string name = path;
    Group group;
    hid_t parent = file;
    for (std::size_t slash; (slash = name.find('/')) != std::string::npos; name.erase(0, slash + 1)) {
        if (slash == 0) continue;
        AFFERENT_TRY(inner, open_group(parent, name.substr(0, slash)));
        group = std::move(inner);
        parent = group.id();
    }
    if (name.empty() || !has_object(parent, name)) return malformed(path, "is missing");
    Numbers numbers{
        .data = Dataset(H5Dopen2(parent, name.c_str(), H5P_DEFAULT)), .space = {}, .dimensions = {}};
    if (!numbers.data) return malformed(path, "is not a dataset");
    const Type type(H5Dget_type(numbers.data.id()));
    const auto kind = type ? H5Tget_class(type.id()) : H5T_NO_CLASS;
    if (kind != H5T_FLOAT && kind != H5T_INTEGER) return malformed(path, "must be of numbers");
    numbers.space = Space(H5Dget_space(numbers.data.id()));
    const int dimensions = numbers.space ? H5Sget_simple_extent_ndims(numbers.space.id()) : -1;
    if (dimensions < static_cast<int>(fewest) || dimensions > static_cast<int>(most))
        return malformed(path, fewest == most ? "must have one dimension"
                                              : "must have two dimensions, scans and elements, or three, "
                                                "scans, rows and columns of an image");
    numbers.dimensions.resize(static_cast<std::size_t>(dimensions));
    H5Sget_simple_extent_dims(numbers.space.id(), numbers.dimensions.data(), nullptr);
    std::uint64_t count = 1;
    for (const hsize_t dimension : numbers.dimensions) {
        if (dimension == 0) return malformed(path, "is empty");
        if (dimension > most_numbers / count) {
            const std::string text = "has more than " + std::to_string(most_numbers) +
                                     " numbers, which take " + std::to_string(most_numbers >> 17U) +
                                     " MB; save it in parts";
            return malformed(path, text.c_str());
        }
        count *= dimension;
    }
    AFFERENT_TRY(check_storage(numbers.data, type.id(), count, path));
    return numbers;
}

Result<std::vector<std::string>> numbers_in(hid_t file, const std::string& group, std::size_t most) {
    Group opened;
    hid_t parent = file;
    std::string rest = group;
    for (std::size_t slash; (slash = rest.find('/')) != std::string::npos; rest.erase(0, slash + 1)) {
        if (slash == 0) continue;
        AFFERENT_TRY(inner, open_group(parent, rest.substr(0, slash)));
        opened = std::move(inner);
        parent = opened.id();
    }
    H5G_info_t info;
    if (H5Gget_info(parent, &info) < 0) return malformed("a group", "cannot be read");
    if (info.nlinks > most) return malformed("a group", "has too many members");
    std::vector<std::string> names;
    for (hsize_t i = 0; i < info.nlinks; ++i) {
        std::string name(256, '\0');
        const auto length = H5Lget_name_by_idx(parent, ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(),
                                               name.size(), H5P_DEFAULT);
        if (length < 0 || static_cast<std::size_t>(length) >= name.size()) continue;
        name.resize(static_cast<std::size_t>(length));
        if (open_numbers(parent, name, 1, 2, most_rows)) names.push_back(std::move(name));
    }
    return names;
}

Result<void> Numbers::read(hsize_t first, std::span<double> values) const {
    std::array<hsize_t, 3> begin{first};
    std::array<hsize_t, 3> count{1, 1, 1};
    std::copy(dimensions.begin() + 1, dimensions.end(), count.begin() + 1);
    const hsize_t size = values.size();
    count[0] = size / (count[1] * count[2]);
    if (dimensions.size() == 2 && dimensions[0] == 1) {
        begin = {0, first};
        count = {1, size, 1};
    }
    const Space piece(H5Screate_simple(1, &size, nullptr));
    if (H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr) < 0 ||
        H5Dread(data.id(), H5T_NATIVE_DOUBLE, piece.id(), space.id(), H5P_DEFAULT, values.data()) < 0)
        return malformed("a dataset", "cannot be read");
    return success();
}

Result<std::vector<std::string>> read_texts(hid_t group, const std::string& name) {
    constexpr std::size_t longest = 1000;
    AFFERENT_TRY(column, open_column(group, name, H5T_STRING));
    const Type type(H5Dget_type(column.data.id()));
    if (H5Tis_variable_str(type.id()) <= 0) return malformed(name, "must be of texts of any length");
    std::vector<char*> read(column.rows, nullptr);
    if (H5Dread(column.data.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, read.data()) < 0)
        return malformed(name, "cannot be read");
    std::vector<std::string> texts;
    for (char* const text : read) {
        if (text)
            texts.emplace_back(text, ::strnlen(text, longest));
        else
            texts.emplace_back();
        H5free_memory(text);
    }
    return texts;
}

std::optional<double> number_attribute(hid_t object, const char* name) {
    if (H5Aexists(object, name) <= 0) return std::nullopt;
    const Attribute attribute(H5Aopen(object, name, H5P_DEFAULT));
    const Type type(attribute ? H5Aget_type(attribute.id()) : H5I_INVALID_HID);
    const Space space(attribute ? H5Aget_space(attribute.id()) : H5I_INVALID_HID);
    double value = 0;
    const auto kind = type ? H5Tget_class(type.id()) : H5T_NO_CLASS;
    if ((kind != H5T_FLOAT && kind != H5T_INTEGER) || !space ||
        H5Sget_simple_extent_npoints(space.id()) != 1 ||
        H5Aread(attribute.id(), H5T_NATIVE_DOUBLE, &value) < 0)
        return std::nullopt;
    return value;
}

std::string text_attribute(hid_t object, const char* name) {
    constexpr std::size_t longest = 100;
    if (H5Aexists(object, name) <= 0) return {};
    const Attribute attribute(H5Aopen(object, name, H5P_DEFAULT));
    const Type type(attribute ? H5Aget_type(attribute.id()) : H5I_INVALID_HID);
    const Space space(attribute ? H5Aget_space(attribute.id()) : H5I_INVALID_HID);
    if (!type || !space || H5Tget_class(type.id()) != H5T_STRING ||
        H5Sget_simple_extent_npoints(space.id()) != 1)
        return {};
    if (H5Tis_variable_str(type.id()) > 0) {
        char* text = nullptr;
        if (H5Aread(attribute.id(), type.id(), &text) < 0 || text == nullptr) return {};
        std::string copy(text);
        H5free_memory(text);
        return copy;
    }
    const std::size_t size = H5Tget_size(type.id());
    if (size > longest) return {};
    std::string text(size, '\0');
    if (H5Aread(attribute.id(), type.id(), text.data()) < 0) return {};
    text.resize(std::min(text.find('\0'), text.size()));
    return text;
}

Result<std::vector<std::string>> groups_in(hid_t group, std::size_t most) {
    H5G_info_t info;
    if (H5Gget_info(group, &info) < 0) return malformed("a group", "cannot be read");
    std::vector<std::string> names;
    for (hsize_t i = 0; i < info.nlinks; ++i) {
        std::string name(256, '\0');
        const auto length = H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(),
                                               name.size(), H5P_DEFAULT);
        if (length < 0 || static_cast<std::size_t>(length) >= name.size())
            return malformed("a group", "has a name that cannot be read");
        name.resize(static_cast<std::size_t>(length));
        if (has_object(group, name) && Group(H5Gopen2(group, name.c_str(), H5P_DEFAULT)))
            names.push_back(std::move(name));
        if (names.size() > most || i > 1000) return malformed("a group", "has too many members");
    }
    return names;
}

File create_file(const char* name) {
    constexpr std::size_t grown_by = std::size_t{1} << 20;
    const Properties properties(H5Pcreate(H5P_FILE_ACCESS));
    if (!properties || H5Pset_fapl_core(properties.id(), grown_by, false) < 0) return {};
    return File(H5Fcreate(name, H5F_ACC_TRUNC, H5P_DEFAULT, properties.id()));
}

bool save(const File& file, const std::filesystem::path& to) {
    if (H5Fflush(file.id(), H5F_SCOPE_GLOBAL) < 0) return false;
    const auto size = H5Fget_file_image(file.id(), nullptr, 0);
    if (size <= 0) return false;
    std::vector<char> image(static_cast<std::size_t>(size));
    if (H5Fget_file_image(file.id(), image.data(), image.size()) != size) return false;
    std::ofstream out(to, std::ios::binary);
    out.write(image.data(), size);
    out.close();
    return bool(out);
}

Dataset write_column(hid_t group, const char* name, std::span<const double> values) {
    return write_data(group, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, row_space(values.size()),
                      values.data());
}

Dataset write_column(hid_t group, const char* name, std::span<const std::uint64_t> values) {
    return write_data(group, name, H5T_STD_U64LE, H5T_NATIVE_UINT64, row_space(values.size()), values.data());
}

Dataset write_column(hid_t group, const char* name, std::span<const std::int64_t> values) {
    return write_data(group, name, H5T_STD_I64LE, H5T_NATIVE_INT64, row_space(values.size()), values.data());
}

bool write_text(hid_t group, const char* name, const std::string& text) {
    const Type type = text_type();
    const char* data = text.c_str();
    return bool(write_data(group, name, type.id(), type.id(), scalar_space(), &data));
}

Dataset write_column(hid_t group, const char* name, const std::vector<std::string>& texts) {
    const Type type = text_type();
    return write_data(group, name, type.id(), type.id(), row_space(texts.size()), pointers(texts).data());
}

bool write_attribute(hid_t object, const char* name, const std::string& text) {
    const Type type = text_type();
    const char* data = text.c_str();
    return write_data_attribute(object, name, type.id(), type.id(), scalar_space(), &data);
}

bool write_attribute(hid_t object, const char* name, const std::vector<std::string>& texts) {
    const Type type = text_type();
    return write_data_attribute(object, name, type.id(), type.id(), row_space(texts.size()),
                                pointers(texts).data());
}

bool write_attribute(hid_t object, const char* name, double value) {
    return write_data_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, scalar_space(), &value);
}

bool write_attribute(hid_t object, const char* name, std::span<const std::uint32_t> values, bool scalar) {
    return write_data_attribute(object, name, H5T_STD_U32LE, H5T_NATIVE_UINT32,
                                scalar ? scalar_space() : row_space(values.size()), values.data());
}

bool write_reference(hid_t object, const char* name, hid_t file, const char* path) {
    hobj_ref_t reference;
    return H5Rcreate(&reference, file, path, H5R_OBJECT, -1) >= 0 &&
           write_data_attribute(object, name, H5T_STD_REF_OBJ, H5T_STD_REF_OBJ, scalar_space(), &reference);
}

}  // namespace afferent::hdf5
