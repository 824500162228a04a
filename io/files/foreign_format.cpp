#include "afferent/io/files/foreign_format.hpp"

#include <array>

namespace afferent {
namespace {

struct Foreign {
    std::string_view begins;
    const char* what_to_do;
};
constexpr std::array formats{
    Foreign{
        "PK\x03\x04",
        "this is a spreadsheet (.xlsx, .ods) or another zip file: save its sheet as CSV; NumPy's files must "
        "end in .npz"},
    Foreign{"\xD0\xCF\x11\xE0", "this is a spreadsheet of an old kind (.xls): save its sheet as CSV"},
    Foreign{"PAR1",
            "this is a Parquet file: write it as CSV, as by python3 -c \"import pandas; "
            "pandas.read_parquet('x.parquet').to_csv('x.csv', index=False)\""},
    Foreign{"ARROW1",
            "this is a Feather file: write it as CSV, as by python3 -c \"import pandas; "
            "pandas.read_feather('x.feather').to_csv('x.csv', index=False)\""},
    Foreign{"\x89HDF", "this is a file in HDF5: call it .h5, or .mat if MATLAB has written it"},
    Foreign{"MATLAB ", "this is a file of MATLAB: call it .mat"},
    Foreign{"\x93NUMPY", "this is a file of NumPy: call it .npy"},
    Foreign{"TDSm", "this is a file of LabVIEW (.tdms): export it as text"},
};

}  // namespace

std::optional<std::string> foreign_format(std::string_view first_bytes) {
    for (const Foreign& format : formats)
        if (first_bytes.starts_with(format.begins)) return format.what_to_do;
    return std::nullopt;
}

}  // namespace afferent
