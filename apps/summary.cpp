#include "afferent/apps/summary.hpp"

#include <fstream>
#include <iomanip>
#include <iostream>

#include "afferent/apps/failure.hpp"

namespace afferent {

std::string json(const Summary& summary, int indent) {
    return summary.dump(indent, ' ', false, Summary::error_handler_t::replace);
}

void print(const Summary& summary) {
    for (const auto& [key, value] : summary.items()) {
        std::string name = key;
        std::replace(name.begin(), name.end(), '_', ' ');
        std::cout << "  " << std::left << std::setw(28) << name;
        if (value.is_string())
            std::cout << value.get<std::string>();
        else if (value.is_number_float())
            std::cout << std::setprecision(6) << value.get<double>();
        else if (value.is_null())
            std::cout << "not known";
        else
            std::cout << json(value);
        std::cout << '\n';
    }
}

void print(const Summary& summary, bool json) {
    if (json)
        std::cout << afferent::json(summary, 2) << '\n';
    else
        print(summary);
}

void write(const Summary& summary, const std::filesystem::path& file) {
    std::ofstream out(file);
    out << json(summary, 2) << '\n';
    out.close();
    if (!out) throw Failure(file.string() + ": cannot be written");
}

}  // namespace afferent
