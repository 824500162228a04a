#include "bench/scale_population.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "afferent/neurons/tuning.hpp"

namespace afferent::bench {
namespace {

constexpr double noise_sd_n = 2;
constexpr double touched_rate_hz = 30;
// Untouched, the afferent with the lowest threshold is below its rheobase.
constexpr double begin_n = 1;

LifParameters scale_neuron(bool adapts) {
    LifParameters neuron;
    if (!adapts) neuron.delta_g = 0;
    return neuron;
}

TimePoint begin_of(std::uint64_t frame) {
    return scene_start + static_cast<Duration::rep>(frame) * scale_frame;
}

}  // namespace

std::uint32_t ScalePopulation::active() const noexcept {
    return static_cast<std::uint32_t>(std::lround(active_fraction * elements));
}

std::string name(scene::Form form) {
    return form == scene::Form::sparse ? "sparse" : form == scene::Form::dense ? "dense" : "automatic";
}

std::string name(Contact contact) { return contact == Contact::block ? "block" : "scattered"; }

Sustained::Parameters scale_encoder(bool adapts) {
    const Tuned tuned = tune(scale_neuron(adapts), {.rate = RateKind::steady,
                                                    .rate_hz = touched_rate_hz,
                                                    .input = scale_touched_n,
                                                    .begin_input = begin_n});
    return {tuned.gain, tuned.bias_mv};
}

Scene scale_scene(const ScaleRun& run) {
    const ScalePopulation& population = run.population;
    const Sustained::Parameters encoder = scale_encoder(population.adapts);
    Scene scene;
    scene.name = "scale";
    scene::Patch patch{.name = "skin", .elements = population.elements};
    patch.sensor.rate_hz = 1 / seconds(scale_frame);
    patch.encoder = scene::Sustained{encoder.gain_mv_per_n, encoder.bias_mv};
    static_cast<LifParameters&>(patch.neuron) = scale_neuron(population.adapts);
    patch.neuron.form = run.form;
    if (population.differs) {
        patch.spread.threshold = scene::Uniform{0.98, 1.02};
        patch.spread.phase = scene::Uniform{0, 1};
    }
    scene.patches = {patch};
    // A source on the sensors' clock, which the sweep needs; the forces are pushed.
    scene.source = scene::Profile{{{0, 0}, {1, 0}}};
    scene.record = {.events = false, .force = false, .picture = false};
    scene.runtime.threads = run.threads;
    return scene;
}

// Every frame begins elsewhere in one long row of random numbers: no two neighbours in time or space feel
// the same, and nothing is drawn while time is taken.
ScaleTouch::ScaleTouch(const ScalePopulation& population)
    : contact_(population.contact), active_(population.active()) {
    if (contact_ == Contact::scattered && active_ > 0) stride_ = population.elements / active_;
    constexpr std::size_t offsets = 4096;
    noise_n_.resize(active_ + offsets);
    std::mt19937_64 random(11);
    std::normal_distribution<> force_n(scale_touched_n, noise_sd_n);
    for (double& each : noise_n_) each = std::max(0.0, force_n(random));
}

std::span<const double> ScaleTouch::forces_n(std::uint64_t frame) const noexcept {
    const std::uint64_t offsets = noise_n_.size() - active_;
    return std::span(noise_n_).subspan(frame * 1021 % offsets, active_);
}

void ScaleTouch::push(std::uint64_t frame, Coprocessor& coprocessor) const {
    if (active_ == 0) return;
    const std::span<const double> forces = forces_n(frame);
    const TimePoint time = begin_of(frame);
    if (contact_ == Contact::block) return coprocessor.push({time, 0, forces});
    for (std::uint32_t i = 0; i < active_; ++i) coprocessor.push({time, element(i), forces.subspan(i, 1)});
}

RunningScale::RunningScale(const ScaleRun& run, const ScaleTouch& touch)
    : touch_(touch), coprocessor_(scale_scene(run)) {}

std::span<const Event> RunningScale::frame() {
    touch_.push(frames_, coprocessor_);
    // Up to the next frame, whose forces are not known yet, but not including its first instant.
    return coprocessor_.advance(begin_of(++frames_) - Duration(1));
}

}  // namespace afferent::bench
