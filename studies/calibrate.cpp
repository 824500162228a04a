#include "afferent/studies/calibrate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "afferent/nodes/patch_sensors.hpp"
#include "afferent/nodes/table_columns.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

// The filter's noise is fitted to forces no nearer to each other than this (a row that comes on time is not
// too near for rounding), and how far off each is.
constexpr double motion_step_s = 0.005 * (1 - 1e-9);
constexpr double motion_noise_n = 0.01;
constexpr std::size_t fewest_motion_steps = 100;
// Where the grip is smaller than this part of its largest, noise is large against the shares.
constexpr double least_grip = 0.1;
// Measured parts are rounded to 1/whole_parts.
constexpr double whole_parts = 1000;

Error malformed_calibration(std::string text) { return {Error::Kind::malformed, std::move(text)}; }

double residual_n(double squares, std::size_t count) {
    return std::sqrt(squares / static_cast<double>(count));
}

bool is_constant(const ForceTrace& trace) {
    return std::ranges::all_of(
        trace, [&](const ForcePoint& point) { return point.force_n == trace.front().force_n; });
}

class Calibrator {
  public:
    explicit Calibrator(const Scene& scene) : plan_(make_plan(scene)) {
        fit_.scene = scene;
        for (const PatchPlan& patch : plan_.patches) shares_.push_back(patch.share);
    }

    // Columns as those of a source; no row is out of range.
    Result<void> read(const Table& table, scene::TableUnit unit) {
        auto understood = table_columns(table.columns, unit);
        const std::string wanted =
            table.file + ":1: must have one column of grip force in newtons, or one for each of the " +
            std::to_string(plan_.elements) + " elements";
        if (!understood) return malformed_calibration(wanted + ": " + understood.error().text);
        TableColumns& of = understood.value();
        const bool newtons = of.quantity == Quantity::force;
        volts_to_counts(of, plan_);
        const bool by_grip = newtons && table.columns.size() == 1;
        if (!by_grip && table.columns.size() != plan_.elements)
            return malformed_calibration(wanted + "; it has " + std::to_string(table.columns.size()) +
                                         ": name those (--columns)");
        if (!by_grip) elements_.resize(plan_.elements);
        for (std::size_t row = 0; row < table.rows(); ++row)
            grip_.push_back({seconds(table.times[row]), by_grip ? of.factors[0] * table.row(row)[0] : 0});
        for (const PatchPlan& patch : plan_.patches) {
            if (by_grip || !patch.owns_elements) continue;
            const PatchSensors sensors(patch, 0);
            for (Address i = patch.first_element; i < patch.first_element + patch.elements(); ++i)
                for (std::size_t row = 0; row < table.rows(); ++row) {
                    const double value = of.factors[i] * table.row(row)[i];
                    const double force_n =
                        newtons ? std::clamp(value, 0.0, patch.sensor.full_scale_n) : sensors.force_n(value);
                    elements_[i].push_back({grip_[row].time_s, force_n});
                }
        }
        for (const ForceTrace& trace : elements_) {
            dead_.push_back(is_constant(trace));
            for (std::size_t row = 0; row < trace.size() && !dead_.back(); ++row)
                grip_[row].force_n += trace[row].force_n;
        }
        return success();
    }

    Result<void> take(std::span<const Event> events) {
        spikes_.resize(plan_.addresses);
        for (const Event& event : events) {
            if (event.address >= plan_.addresses)
                return malformed_calibration("an event of address " + std::to_string(event.address) +
                                             ", and the scene has " + std::to_string(plan_.addresses) +
                                             " addresses");
            spikes_[event.address].push_back(event.time);
        }
        return success();
    }

    SceneFit result(bool with_spikes) {
        if (!elements_.empty()) fit_shares();
        if (with_spikes) {
            if (elements_.empty()) fit_shares_by_spikes();
            for (std::size_t i = 0; i < plan_.patches.size(); ++i)
                if (plan_.patches[i].proportional()) fit_drives(i);
            if (!elements_.empty()) fit_gain_spread();
        }
        fit_motion();
        // What passes can be run.
        fit_.scene.check();
        return std::move(fit_);
    }

  private:
    // The share that fits each element best: Σ f F / Σ F².
    void fit_shares() {
        double squares = 0;
        for (const ForcePoint& point : grip_) squares += point.force_n * point.force_n;
        if (!(squares > 0)) return;
        for (std::size_t patch = 0; patch < plan_.patches.size(); ++patch) {
            const PatchPlan& of = plan_.patches[patch];
            if (!of.owns_elements) continue;
            for (std::uint32_t i = 0; i < of.elements(); ++i) {
                const ForceTrace& trace = elements_[of.first_element + i];
                if (dead_[of.first_element + i]) {
                    leave_out(patch, i);
                    continue;
                }
                double product = 0;
                for (std::size_t row = 0; row < trace.size(); ++row)
                    product += trace[row].force_n * grip_[row].force_n;
                const double share = product / squares;
                double left = 0;
                for (std::size_t row = 0; row < trace.size(); ++row)
                    left += std::pow(trace[row].force_n - share * grip_[row].force_n, 2);
                shares_[patch][i] = share;
                fit_.elements.push_back({of.name, i, share, residual_n(left, trace.size())});
            }
        }
        fit_wander();
        write_shares();
    }

    void leave_out(std::size_t patch, std::uint32_t element) {
        shares_[patch][element] = 0;
        auto& dead = fit_.scene.patches[patch].sensor.dead_element;
        if (std::ranges::find(dead, element) == dead.end()) dead.push_back(element);
        fit_.elements.push_back({plan_.patches[patch].name, element, 0.0, std::nullopt, true});
    }

    // Of one element: its share over time, relative to the constant one and less 1.
    struct Deviation {
        double share;
        std::vector<double> parts;
    };

    void fit_wander() {
        double largest_n = 0;
        for (const ForcePoint& point : grip_) largest_n = std::max(largest_n, point.force_n);
        std::vector<std::size_t> rows;
        for (std::size_t row = 0; row < grip_.size(); ++row)
            if (grip_[row].force_n > least_grip * largest_n &&
                (rows.empty() || grip_[row].time_s >= grip_[rows.back()].time_s + motion_step_s))
                rows.push_back(row);
        if (rows.size() < fewest_motion_steps) return;
        std::vector<Deviation> deviations;
        double shares = 0;
        double squares = 0;
        for (std::size_t patch = 0; patch < plan_.patches.size(); ++patch) {
            const PatchPlan& of = plan_.patches[patch];
            for (std::uint32_t i = 0; of.owns_elements && i < of.elements(); ++i) {
                const double share = shares_[patch][i];
                if (!(share > 0)) continue;
                Deviation& deviation = deviations.emplace_back(Deviation{share, {}});
                double sum = 0;
                for (const std::size_t row : rows)
                    sum += std::pow(
                        deviation.parts.emplace_back(
                            elements_[of.first_element + i][row].force_n / (share * grip_[row].force_n) - 1),
                        2);
                shares += share;
                squares += share * sum / static_cast<double>(rows.size());
            }
        }
        if (!(shares > 0)) return;
        const double part = std::round(whole_parts * std::sqrt(squares / shares)) / whole_parts;
        fit_.shares_wander = {std::min(part, 10.0), fit_.scene.uncertainty.share_time_s};
        if (part > 0) fit_.shares_wander->time_s = std::max(0.001, wander_time_s(rows, deviations));
        fit_.scene.uncertainty.share = fit_.shares_wander->part;
        fit_.scene.uncertainty.share_time_s = fit_.shares_wander->time_s;
    }

    // The autocovariance at lags of whole rows, on a straight line from one that is computed to the next. At
    // least as long as half of the recording where it does not fall so far.
    double wander_time_s(const std::vector<std::size_t>& rows, std::vector<Deviation>& deviations) const {
        for (Deviation& deviation : deviations) {
            const double mean = std::accumulate(deviation.parts.begin(), deviation.parts.end(), 0.0) /
                                static_cast<double>(rows.size());
            for (double& part : deviation.parts) part -= mean;
        }
        struct Lag {
            double time_s, covariance;
        };
        const auto at = [&](std::size_t lag) {
            double covariance = 0;
            double time_s = 0;
            const std::size_t pairs = rows.size() - lag;
            for (std::size_t k = 0; k < pairs; ++k)
                time_s += grip_[rows[k + lag]].time_s - grip_[rows[k]].time_s;
            for (const auto& [share, parts] : deviations)
                for (std::size_t k = 0; k < pairs; ++k) covariance += share * parts[k] * parts[k + lag];
            return Lag{time_s / static_cast<double>(pairs), covariance / static_cast<double>(pairs)};
        };
        const double wanted = at(0).covariance / std::numbers::e;
        Lag before = at(0);
        for (std::size_t lag = 1; lag <= rows.size() / 2; lag += 1 + lag / 10) {
            const Lag now = at(lag);
            if (now.covariance <= wanted) {
                const double part = (before.covariance - wanted) / (before.covariance - now.covariance);
                return before.time_s + part * (now.time_s - before.time_s);
            }
            before = now;
        }
        return before.time_s;
    }

    // From the slopes over the grip force, which are gain times share. Patches without shares in the scene
    // are one group.
    void fit_shares_by_spikes() {
        struct Group {
            double slopes = 0;
            double shares = 0;
            double gain() const { return slopes / shares; }
        };
        struct Slope {
            std::size_t patch;
            std::uint32_t element;
            double mv_per_n;
        };
        std::vector<Slope> slopes;
        std::vector<Group> groups(plan_.patches.size() + 1);
        const auto group_of = [&](std::size_t patch) -> Group& {
            return fit_.scene.patches[patch].share.empty() ? groups.back() : groups[patch];
        };
        for (std::size_t patch = 0; patch < plan_.patches.size(); ++patch) {
            const PatchPlan& of = plan_.patches[patch];
            if (!of.owns_elements || !of.proportional() || !of.fields.is_one_each()) continue;
            for (std::uint32_t i = 0; i < of.afferents(); ++i) {
                const auto fit = fit_drive(samples_of(of, of.first + i, grip_));
                if (!fit || !(fit->gain_mv_per_n > 0)) continue;
                slopes.push_back({patch, i, fit->gain_mv_per_n});
                group_of(patch).slopes += fit->gain_mv_per_n;
                group_of(patch).shares += of.share[i];
            }
        }
        for (const auto& [patch, element, mv_per_n] : slopes) {
            if (!(group_of(patch).shares > 0)) continue;
            shares_[patch][element] = mv_per_n / group_of(patch).gain();
            fit_.elements.push_back(
                {plan_.patches[patch].name, element, shares_[patch][element], std::nullopt});
        }
        if (!fit_.elements.empty()) write_shares();
    }

    // Rounding must not carry the sum above 1, which no scene may pass.
    void write_shares() {
        double sum = 0;
        for (std::size_t i = 0; i < plan_.patches.size(); ++i)
            if (plan_.patches[i].owns_elements)
                sum += std::accumulate(shares_[i].begin(), shares_[i].end(), 0.0);
        for (std::size_t i = 0; i < plan_.patches.size(); ++i) {
            if (!plan_.patches[i].owns_elements) {
                shares_[i] = shares_[plan_.patches[i].reads];
                continue;
            }
            for (double& share : shares_[i]) share /= std::max(1.0, sum);
            fit_.scene.patches[i].share = shares_[i];
        }
    }

    // A sample is held for the sensor's interval.
    std::vector<DriveSample> samples_of(const PatchPlan& patch, Address address,
                                        const ForceTrace& force) const {
        return drive_samples(patch.neuron_of(address - patch.first), spikes_[address], force,
                             patch.scan_interval / 2);
    }

    // What an afferent felt, at the times of the table.
    ForceTrace felt_by(std::size_t index, std::uint32_t afferent) const {
        const PatchPlan& patch = plan_.patches[index];
        ForceTrace felt = grip_;
        std::vector<double> forces_n = shares_[index];
        const double share = patch.fields.sum(afferent, forces_n);
        for (std::size_t row = 0; row < felt.size(); ++row) {
            felt[row].force_n *= share;
            if (elements_.empty()) continue;
            for (std::uint32_t i = 0; i < patch.elements(); ++i)
                forces_n[i] = elements_[patch.first_element + i][row].force_n;
            felt[row].force_n = patch.fields.sum(afferent, forces_n);
        }
        return felt;
    }

    void fit_drives(std::size_t index) {
        const PatchPlan& of = plan_.patches[index];
        SceneFit::Patch patch{.index = index, .fit = {}, .afferents = {}, .samples = {}};
        for (std::uint32_t i = 0; i < of.afferents(); ++i) {
            const auto samples = samples_of(of, of.first + i, felt_by(index, i));
            patch.afferents.push_back({of.first + i, fit_drive(samples)});
            patch.samples.insert(patch.samples.end(), samples.begin(), samples.end());
        }
        patch.fit = fit_drive(patch.samples);
        if (patch.fit && patch.fit->gain_mv_per_n > 0)
            fit_.scene.patches[index].encoder =
                scene::Sustained{patch.fit->gain_mv_per_n, patch.fit->bias_mv};
        fit_.patches.push_back(std::move(patch));
    }

    // Of the gains of single afferents about those of their patches, over the forces that their own elements
    // told.
    void fit_gain_spread() {
        double squares = 0;
        double afferents = 0;
        for (const SceneFit::Patch& patch : fit_.patches) {
            // Gains that differ as the scene says are known, and one afferent differs from no other.
            if (!plan_.patches[patch.index].variations.empty() || patch.afferents.size() < 2) continue;
            for (const SceneFit::Afferent& afferent : patch.afferents) {
                if (!afferent.fit || !(patch.fit->gain_mv_per_n > 0)) continue;
                squares += std::pow(afferent.fit->gain_mv_per_n / patch.fit->gain_mv_per_n - 1, 2);
                ++afferents;
            }
        }
        if (afferents < 2) return;
        fit_.gain_spread =
            std::min(1.0, std::round(whole_parts * std::sqrt(squares / afferents)) / whole_parts);
        fit_.scene.uncertainty.gain = *fit_.gain_spread;
    }

    void fit_motion() {
        ForceTrace force;
        for (const ForcePoint& point : grip_)
            if (force.empty() || point.time_s >= force.back().time_s + motion_step_s) force.push_back(point);
        if (force.size() < fewest_motion_steps) return;
        fit_.motions = fit_motions(force, motion_noise_n);
        if (auto* filter = std::get_if<scene::Filter>(&fit_.scene.decoder.kind)) {
            const auto& motion = fit_.motions->force.motion;
            filter->hold = {motion[0].speed_n_per_s, motion[0].drift_n2_per_s};
            filter->movement.speed_n_per_s = motion[1].speed_n_per_s;
            filter->contact.speed_n_per_s = motion[2].speed_n_per_s;
        }
    }

    Plan plan_;
    SceneFit fit_;
    std::vector<std::vector<double>> shares_;  // by patch
    ForceTrace grip_;
    std::vector<ForceTrace> elements_;  // empty: the grip force alone is known
    std::vector<bool> dead_;            // of them, those that never change
    std::vector<std::vector<TimePoint>> spikes_;
};

}  // namespace

Result<SceneFit> calibrate(const Scene& scene, const Table& forces, std::span<const Event> events,
                           scene::TableUnit unit) {
    Calibrator calibrator(scene);
    AFFERENT_TRY(calibrator.read(forces, unit));
    AFFERENT_TRY(calibrator.take(events));
    return calibrator.result(!events.empty());
}

}  // namespace afferent
