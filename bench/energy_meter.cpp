#include "bench/energy_meter.hpp"

#include <fstream>

namespace afferent::bench {
namespace {

std::optional<double> number_in(const std::filesystem::path& file) {
    std::ifstream in(file);
    double value = 0;
    if (in >> value) return value;
    return std::nullopt;
}

// "intel-rapl:0" is a package, "intel-rapl:0:1" a part of it. AMD's processors have the same names.
bool is_package(const std::string& name) {
    const std::string prefix = "intel-rapl:";
    return name.starts_with(prefix) && name.find(':', prefix.size()) == std::string::npos;
}

}  // namespace

EnergyMeter::EnergyMeter(const std::filesystem::path& folder) {
    std::error_code absent;
    bool any = false;
    for (const auto& entry : std::filesystem::directory_iterator(folder, absent)) {
        if (!is_package(entry.path().filename().string())) continue;
        any = true;
        const auto now_uj = number_in(entry.path() / "energy_uj");
        const auto range_uj = number_in(entry.path() / "max_energy_range_uj");
        if (now_uj && range_uj) packages_.push_back({entry.path() / "energy_uj", *range_uj, *now_uj});
    }
    if (!packages_.empty()) return;
    unavailable_ = any ? "the counters in " + folder.string() + " can be read by root only"
                       : "there are no RAPL counters in " + folder.string();
}

std::optional<double> EnergyMeter::joules() {
    if (packages_.empty()) return std::nullopt;
    double sum_uj = 0;
    for (Package& package : packages_) {
        const auto now_uj = number_in(package.counter);
        if (!now_uj) return std::nullopt;
        sum_uj += *now_uj - package.last_uj + (*now_uj < package.last_uj ? package.range_uj : 0);
        package.last_uj = *now_uj;
    }
    return 1e-6 * sum_uj;
}

}  // namespace afferent::bench
