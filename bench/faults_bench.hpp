// Question: what do floods and hostile peers do to a hand, its steps, its events, its memory and its grip?
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace afferent::bench {

struct FaultsOptions {
    std::filesystem::path program;  // `afferent`
    std::filesystem::path out;
    bool quick = false;
};

struct FaultsRow {
    std::string transport;
    std::string fault;
    double rate = 0;  // reached: what is done per second; of idle connections how many there are
    // How late the steps of the hand began.
    std::optional<double> step_p50_ms;
    std::optional<double> step_p99_ms;
    std::optional<double> step_max_ms;
    std::optional<double> events_lost_pct;  // none where the coprocessor was killed before the attack
    double rss_mb = 0;                      // the most that the hand held
    std::string grip_state;                 // near the end of the attack
    bool has_coprocessor = true;
};

// A hand and a coprocessor, as processes in real time on a link of this machine, while others attack the
// hand. In the rows where the attackers play the coprocessor, the real one is killed before. Writes
// faults.csv and prints each row. Returns the rows in which the grip was not as it must be: safe without a
// coprocessor. Throws std::runtime_error where nothing can be measured.
std::vector<FaultsRow> run_faults_bench(const FaultsOptions& options, std::ostream& report);

}  // namespace afferent::bench
