#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>

#include "bench/comparison.hpp"
#include "bench/error_bench.hpp"
#include "bench/solver.hpp"
#include "bench/stability_bench.hpp"
#include "bench/truth.hpp"

namespace afferent::bench {
namespace {

// A drive that is held, so that the order shows: where it jumps, a step that begins there loses nothing.
Workload held_drive() {
    Workload workload;
    workload.parameters = {{.delta_g = 0.3}};
    workload.times = {scene_start};
    workload.drives_mv = {45};
    workload.until = scene_start + 200ms;
    return workload;
}

Comparison errors_of(const SolverSpec& spec, const Workload& workload, const Train& truth) {
    Trains trains(1);
    const auto solver = make_solver(spec);
    solver->prepare(workload);
    solver->run(workload, trains);
    Comparison errors;
    errors.add(truth, trains[0]);
    EXPECT_GT(errors.errors_s.size(), 5U) << spec.text() << ": no spikes to compare";
    return errors;
}

// How fast the error falls as steps shrink by four, in powers of the step.
double order_of(const std::string& solver, double step_ms) {
    const Workload workload = held_drive();
    const Train truth = true_train(workload, 0);
    const double coarse = errors_of({solver, step_ms}, workload, truth).rms_s();
    const double fine = errors_of({solver, step_ms / 4}, workload, truth).rms_s();
    return std::log(coarse / fine) / std::log(4);
}

TEST(SteppingSolvers, ConvergeAtTheirOrder) {
    // A spike that is put at a step's end is off by chance, and so are errors of few spikes.
    for (const char* name : {"euler", "euler-interpolated", "euler-corrected", "exponential-euler", "rk4"})
        EXPECT_NEAR(order_of(name, 0.04), 1, 0.5) << name;
    // Its frozen conductance is first order; the rest is better than that.
    EXPECT_GT(order_of("exponential-euler-corrected", 0.1), 0.8);
    EXPECT_NEAR(order_of("rk4-corrected", 0.5), 4, 0.35);
    // The single digits of a float end that soon.
    EXPECT_GT(order_of("rk4-float-corrected", 4), 2);
}

// Two whole tiles and a part of one, on drives that differ: no lane, and no crossing among many in one step,
// gets another's.
TEST(SteppingSolvers, AreRightOnEveryInstructionSet) {
    Workload workload;
    workload.parameters = {{.delta_g = 0.3}};
    workload.neurons = 1033;
    for (int row = 0; row < 40; ++row) {
        workload.times.push_back(scene_start + row * 5ms);
        for (std::size_t i = 0; i < workload.neurons; ++i)
            workload.drives_mv.push_back(10 + 60 * static_cast<double>((i * 7 + row * 3UL) % 101) / 100);
    }
    workload.until = scene_start + 200ms;
    const auto trains_of = [&](const SolverSpec& spec) {
        Trains trains(workload.neurons);
        const auto solver = make_solver(spec);
        solver->prepare(workload);
        solver->run(workload, trains);
        return trains;
    };
    const Trains truth = trains_of({"exact"});
    for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
        hwy::SetSupportedTargetsForTest(targets & -targets);
        for (const char* name : {"rk4-float-corrected", "rk4-corrected"}) {
            const Trains trains = trains_of({name, 0.25});
            Comparison errors;
            for (std::size_t i = 0; i < workload.neurons; ++i) errors.add(truth[i], trains[i]);
            EXPECT_EQ(errors.missed + errors.extra, 0U) << name;
            // Grazing spikes are the worst: there a unit in v's last place is a long time.
            EXPECT_LT(errors.quantile_s(0.99), 1e-6) << name;
            EXPECT_GT(errors.errors_s.size(), 5000U);
        }
        hwy::SetSupportedTargetsForTest(0);
    }
}

TEST(AdaptiveSolvers, FollowTheirTolerance) {
    const Workload workload = held_drive();
    const Train truth = true_train(workload, 0);
    for (const char* name : {"dopri5", "rosenbrock"}) {
        const double coarse = errors_of({name, 1e-4}, workload, truth).rms_s();
        const double fine = errors_of({name, 1e-8}, workload, truth).rms_s();
        EXPECT_LT(fine, 0.02 * coarse) << name;
        EXPECT_LT(fine, 1e-8) << name;
    }
    for (const std::string& name : cvode_solver_names()) {
        const Comparison errors = errors_of({name, 1e-10}, workload, truth);
        EXPECT_EQ(errors.missed + errors.extra, 0U) << name;
        EXPECT_LT(errors.rms_s(), 1e-7) << name;
    }
}

TEST(ExactSolvers, AreRightToRounding) {
    const Workload workload = held_drive();
    const Train truth = true_train(workload, 0);
    for (const char* name : {"exact", "dense"}) {
        const Comparison errors = errors_of({name}, workload, truth);
        EXPECT_EQ(errors.missed + errors.extra, 0U);
        EXPECT_LT(errors.max_s(), 1e-14) << name;
    }
}

TEST(FixedPointSolvers, FollowTheirTickAndTheirBits) {
    const Workload workload = held_drive();
    const Train truth = true_train(workload, 0);
    const auto rms_s = [&](const char* name, double tick_ms) {
        return errors_of({name, tick_ms}, workload, truth).rms_s();
    };
    EXPECT_LT(rms_s("fixed-24", 0.1), 0.3 * rms_s("fixed-24", 1));
    EXPECT_LT(rms_s("fixed-24", 0.1), rms_s("fixed-12", 0.1));
    // Spikes come at the ends of ticks, and add up.
    EXPECT_LT(rms_s("fixed-24", 0.1), 5e-4);
}

TEST(FixedPointSolvers, RefuseATickThatIsNone) {
    const auto solver = make_solver({"fixed-16", 1e-5});
    EXPECT_THROW(solver->prepare(held_drive()), Unserved);
}

TEST(Solvers, AreNamedWithTheirSetting) {
    EXPECT_EQ(parse_solver("euler:0.1").text(), "euler:0.1");
    EXPECT_EQ(parse_solver("exact").text(), "exact");
    for (const char* bad : {"", "eulr", "euler:", "euler:x", "euler:0", "euler:-1", "euler:nan", "euler:1:2"})
        EXPECT_THROW(parse_solver(bad), std::runtime_error) << bad;
}

TEST(Comparison, CountsWhatIsMissedAndExtra) {
    const auto train = [](std::initializer_list<int> times_ms) {
        Train result;
        for (const int time_ms : times_ms)
            result.push_back({scene_start + std::chrono::milliseconds(time_ms), Interval(0)});
        return result;
    };
    Comparison errors;
    errors.add(train({10, 20, 30, 40}), train({11, 30, 34, 41}));
    EXPECT_EQ(errors.missed, 1U);
    EXPECT_EQ(errors.extra, 1U);
    ASSERT_EQ(errors.errors_s.size(), 3U);
    EXPECT_DOUBLE_EQ(errors.max_s(), 1e-3);
}

TEST(StabilityBench, FindsNoCaseThatTheExactSolverFails) {
    const auto out = std::filesystem::temp_directory_path() / "afferent_stability_test";
    std::ostringstream report;
    EXPECT_EQ(run_stability_bench(out, true, report), 0U) << report.str();
    EXPECT_GT(std::filesystem::file_size(out / "stability.csv"), 1000U);
    std::filesystem::remove_all(out);
}

}  // namespace
}  // namespace afferent::bench
