#include "bench/stability_case.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "afferent/neurons/models.hpp"
#include "bench/table_file.hpp"

namespace afferent::bench {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double denormal = std::numeric_limits<double>::denorm_min();
constexpr std::size_t spikes_in_a_case = 6;

Workload held(std::string name, const LifParameters& parameters, double drive_mv) {
    Workload workload;
    workload.name = std::move(name);
    workload.parameters = {parameters};
    workload.times = {scene_start};
    workload.drives_mv = {drive_mv};
    workload.until = scene_start + rounded(Seconds(1e6));
    workload.max_spikes = spikes_in_a_case;
    return workload;
}

void add_corners(std::vector<StabilityCase>& cases, bool quick) {
    const std::vector<double> ratios =
        quick ? std::vector<double>{1e-8, 1, 1e8} : std::vector<double>{1e-8, 1e-4, 1e-2, 1, 1e2, 1e4, 1e8};
    const std::vector<double> jumps =
        quick ? std::vector<double>{0, 1, 1e6} : std::vector<double>{0, 1e-6, 0.01, 1, 30, 1e3, 1e6};
    for (const double a : ratios) {
        for (const double delta_g : jumps) {
            LifParameters p;
            p.tau_g_ms = a * p.tau_m_ms;
            p.delta_g = delta_g;
            const double rheobase = p.rheobase_mv();
            const std::vector<std::pair<std::string, double>> drives{
                {"-1e9", -1e9},
                {"below", std::nextafter(rheobase, 0)},
                {"at", rheobase},
                {"above", std::nextafter(rheobase, infinity)},
                {"1+1e-9", rheobase * (1 + 1e-9)},
                {"2", rheobase * 2},
                {"1e9", 1e9},
            };
            for (const auto& [name, drive_mv] : drives)
                cases.push_back({held("corner a=" + number(a) + " dg=" + number(delta_g) + " drive=" + name,
                                      p, drive_mv)});
        }
    }
}

// Drives that change at intervals from 1 ns to minutes.
void add_random(std::vector<StabilityCase>& cases, int count) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<> unit;
    const auto between = [&](double low, double high) { return low * std::pow(high / low, unit(random)); };
    for (int i = 0; i < count; ++i) {
        LifParameters p;
        p.tau_m_ms = between(0.1, 1e3);
        p.tau_g_ms = p.tau_m_ms * between(1e-8, 1e8);
        p.delta_g = unit(random) < 0.2 ? 0 : between(1e-6, 1e6);
        p.v_th_mv = -60 + 40 * unit(random);
        p.v_r_mv = p.v_th_mv - between(0.01, 100);
        p.e_k_mv = p.v_th_mv - between(0.01, 100);
        Workload workload = held("random " + std::to_string(i), p, 0);
        workload.times.clear();
        workload.drives_mv.clear();
        Duration time{};
        for (int row = 0; row < 8; ++row) {
            const double rheobase = p.rheobase_mv();
            const double kind = unit(random);
            const double drive_mv = kind < 0.2 ? -between(1, 1e9)
                                    : kind < 0.4
                                        ? rheobase * (1 + between(1e-15, 1))
                                        : rheobase + between(1e-3, 1e9) * (1 + p.delta_g * unit(random));
            workload.times.push_back(scene_start + time);
            workload.drives_mv.push_back(std::clamp(drive_mv, -1e9, 1e9));
            time += Duration(static_cast<Duration::rep>(between(1, 1e11)));
        }
        workload.until = scene_start + time;
        cases.push_back({std::move(workload)});
    }
}

void add_meaningless(std::vector<StabilityCase>& cases) {
    struct Field {
        const char* name;
        double LifParameters::*at;
    };
    constexpr Field fields[] = {
        {"tau_m_ms", &LifParameters::tau_m_ms}, {"tau_g_ms", &LifParameters::tau_g_ms},
        {"v_r_mv", &LifParameters::v_r_mv},     {"v_th_mv", &LifParameters::v_th_mv},
        {"e_k_mv", &LifParameters::e_k_mv},     {"delta_g", &LifParameters::delta_g},
    };
    const auto has_meaning = [](const LifParameters& p) {
        try {
            smallest_neuron(p);
            return true;
        } catch (const std::exception&) {
            return false;
        }
    };
    for (const double value : {nan, infinity, -infinity, denormal, 0.0, -1.0}) {
        for (const Field& field : fields) {
            LifParameters p;
            p.*field.at = value;
            cases.push_back({held(std::string(field.name) + "=" + number(value), p, 30), has_meaning(p)});
        }
        cases.push_back({held("drive_mv=" + number(value), {}, value), std::isfinite(value)});
    }
}

}  // namespace

std::vector<StabilityCase> stability_cases(bool quick) {
    std::vector<StabilityCase> cases;
    add_corners(cases, quick);
    add_random(cases, quick ? 40 : 1000);
    add_meaningless(cases);
    return cases;
}

}  // namespace afferent::bench
