// The energy that the processors take, where the machine tells.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace afferent::bench {

// Reads the counters of Linux's powercap (RAPL): one for each processor package.
class EnergyMeter {
  public:
    explicit EnergyMeter(const std::filesystem::path& folder = "/sys/class/powercap");

    // Why there is nothing to read; empty if there is.
    const std::string& unavailable() const noexcept { return unavailable_; }

    // Joules since construction or the last call, of all packages together. Counters overflow every few
    // minutes at full load: call at least once a minute. Nothing where the machine does not tell.
    std::optional<double> joules();

  private:
    struct Package {
        std::filesystem::path counter;
        double range_uj;
        double last_uj;
    };
    std::vector<Package> packages_;
    std::string unavailable_;
};

}  // namespace afferent::bench
