#include "afferent/io/files/mat_file.hpp"

#include <matio.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

namespace afferent {
namespace {

constexpr std::size_t most_variables = 1000;

Error refused(std::string text) { return {Error::Kind::malformed, std::move(text)}; }

struct CloseMat {
    void operator()(mat_t* file) const noexcept { Mat_Close(file); }
    void operator()(matvar_t* variable) const noexcept { Mat_VarFree(variable); }
};
using MatFile = std::unique_ptr<mat_t, CloseMat>;
using MatVariable = std::unique_ptr<matvar_t, CloseMat>;

template <class Number>
void copy_numbers(const matvar_t& variable, std::vector<double>& values) {
    const auto* const numbers = static_cast<const Number*>(variable.data);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(numbers[i]);
}

// Column by column, as MATLAB holds them. Empty: it is not of real numbers.
std::vector<double> numbers_of(const matvar_t& variable) {
    std::vector<double> values(variable.dims[0] * variable.dims[1]);
    if (variable.nbytes < values.size() * static_cast<std::size_t>(variable.data_size)) return {};
    switch (variable.class_type) {
        case MAT_C_DOUBLE:
            copy_numbers<double>(variable, values);
            break;
        case MAT_C_SINGLE:
            copy_numbers<float>(variable, values);
            break;
        case MAT_C_INT8:
            copy_numbers<std::int8_t>(variable, values);
            break;
        case MAT_C_UINT8:
            copy_numbers<std::uint8_t>(variable, values);
            break;
        case MAT_C_INT16:
            copy_numbers<std::int16_t>(variable, values);
            break;
        case MAT_C_UINT16:
            copy_numbers<std::uint16_t>(variable, values);
            break;
        case MAT_C_INT32:
            copy_numbers<std::int32_t>(variable, values);
            break;
        case MAT_C_UINT32:
            copy_numbers<std::uint32_t>(variable, values);
            break;
        case MAT_C_INT64:
            copy_numbers<std::int64_t>(variable, values);
            break;
        case MAT_C_UINT64:
            copy_numbers<std::uint64_t>(variable, values);
            break;
        default:
            return {};
    }
    return values;
}

bool is_matrix(const matvar_t& variable) {
    return variable.rank == 2 && variable.dims && variable.dims[0] > 0 && variable.dims[1] > 0 &&
           variable.isComplex == 0 && variable.dims[0] <= Table::most_values / variable.dims[1];
}

class MatReader {
  public:
    Result<void> read(const std::filesystem::path& file) {
        const MatFile opened(Mat_Open(file.c_str(), MAT_ACC_RDONLY));
        if (!opened) return refused("is no file of MATLAB, or is cut off");
        for (std::size_t i = 0;; ++i) {
            const MatVariable variable(Mat_VarReadNextInfo(opened.get()));
            if (!variable) return success();
            if (i == most_variables)
                return refused("has more than " + std::to_string(most_variables) + " variables");
            if (variable->class_type != MAT_C_STRUCT && !is_matrix(*variable)) {
                passed_over_ = passed_over_ || variable->class_type == MAT_C_OPAQUE;
                continue;
            }
            // A structure is read with all its fields.
            if (Mat_VarReadDataAll(opened.get(), variable.get()) != 0) continue;
            AFFERENT_TRY(take(*variable));
        }
    }

    Result<void> send(const TableOptions& options, const SendPiece& send) {
        if (groups_.empty())
            return refused(
                passed_over_ ? "has no variables of numbers; a table of MATLAB is not read: save its columns "
                               "as variables, or by writetable(x, 'x.csv')"
                             : "has no variables of numbers");
        AFFERENT_TRY(group, group_of_table(asked_group(options), groups_));
        std::erase_if(arrays_, [&group = group](const NumberArray& array) {
            return array.name.substr(0, array.name.rfind('/') + 1) != group;
        });
        return send_columns(std::move(arrays_), options, send);
    }

  private:
    Result<void> take(matvar_t& variable) {
        if (!variable.name) return success();
        const std::string name = variable.name;
        if (variable.class_type != MAT_C_STRUCT) return take_numbers("", name, variable);
        const unsigned fields = Mat_VarGetNumberOfFields(&variable);
        char* const* const names = Mat_VarGetStructFieldnames(&variable);
        for (unsigned i = 0; names && i < std::min<std::size_t>(fields, most_variables); ++i) {
            const matvar_t* const field = Mat_VarGetStructFieldByIndex(&variable, i, 0);
            if (!field || !field->data || !names[i] || !is_matrix(*field)) continue;
            AFFERENT_TRY(take_numbers(name + "/", names[i], *field));
        }
        return success();
    }

    Result<void> take_numbers(const std::string& group, const std::string& name, const matvar_t& variable) {
        const auto values = std::make_shared<std::vector<double>>(numbers_of(variable));
        if (values->empty()) return success();
        held_ += values->size();
        if (held_ > Table::most_values)
            return refused("has more than " + std::to_string(Table::most_values) +
                           " numbers, for which 256 MB are needed: save it as HDF5, or in parts");
        const std::uint64_t rows = variable.dims[0];
        const std::uint64_t columns = variable.dims[1];
        auto of_group = std::ranges::find(groups_, group, &DatasetGroup::path);
        if (of_group == groups_.end()) of_group = groups_.insert(groups_.end(), {group, {}});
        of_group->names.push_back(name);
        arrays_.push_back(
            {.name = group + name,
             .rows = rows,
             .columns = columns,
             .read = [values, rows, columns](std::uint64_t first, std::span<double> read) -> Result<void> {
                 // One row is read as one column.
                 const std::uint64_t width = rows == 1 ? 1 : columns;
                 const std::uint64_t height = rows == 1 ? columns : rows;
                 for (std::uint64_t i = 0; i < read.size(); ++i)
                     read[i] = (*values)[i % width * height + first + i / width];
                 return success();
             }});
        return success();
    }

    std::vector<NumberArray> arrays_;
    std::vector<DatasetGroup> groups_;
    std::uint64_t held_ = 0;
    bool passed_over_ = false;
};

}  // namespace

Result<void> send_mat(const std::filesystem::path& file, const TableOptions& options, const SendPiece& send) {
    MatReader reader;
    AFFERENT_TRY(reader.read(file));
    return reader.send(options, send);
}

}  // namespace afferent
