// A neuron by itself: its rates, and its spikes under a drive.
#include <algorithm>
#include <optional>

#include "afferent/neurons/rate.hpp"
#include "afferent/neurons/sparse_population.hpp"
#include "afferent/python/bindings.hpp"
#include "afferent/runtime/spike_storm.hpp"

namespace afferent::python {
namespace {

// More spikes of a neuron in 5 ms end the run, as in a scene.
constexpr SpikeLimit spike_limit{1000, 5ms};

struct StateRow {
    double v_mv;
    double g;
};

RateKind rate_kind(const std::string& name) {
    if (name == "steady") return RateKind::steady;
    if (name == "onset") return RateKind::onset;
    throw py::value_error("kind must be steady or onset, is " + name);
}

// f of each number, in an array of the same shape; a number of a number.
template <class F>
py::object for_each_number(const Numbers& numbers, const F& f) {
    Numbers results(std::vector<py::ssize_t>(numbers.shape(), numbers.shape() + numbers.ndim()));
    {
        const double* from = numbers.data();
        double* to = results.mutable_data();
        const py::gil_scoped_release unlocked;
        std::transform(from, from + numbers.size(), to, f);
    }
    return numbers.ndim() == 0 ? py::object(py::float_(*results.data())) : py::object(std::move(results));
}

// Rows of drives in mV, each held from its time until the next; before the first the drive is 0.
struct Drives {
    std::span<const std::int64_t> times_ns;
    std::span<const double> drives_mv;
    std::size_t neurons;
};

struct Traces {
    std::vector<Event> events;
    std::vector<StateRow> states;  // of all neurons at each time
};

// The spikes up to `until`, from rest on, and the states at those times.
Traces carry_out(const NeuronModel& model, const Drives& drives, TimePoint until,
                 std::span<const std::int64_t> at_ns, Watch& watch) {
    Traces traces;
    visit_neuron(model, [&](auto neuron) {
        using Neuron = decltype(neuron);
        SparsePopulation<Neuron> population(neuron, drives.neurons, spike_limit);
        const auto advance = [&](TimePoint time) {
            population.advance(time, [&](TimePoint spike, std::uint32_t i) {
                traces.events.push_back({spike, i});
            });
            if (const auto& storm = population.storm())
                throw SpikeStormError(storm->index, storm->time, describe(model));
            watch.at(seconds(time) / seconds(until));
        };
        std::size_t sample = 0;
        // A state at the time of a row is that before the row's drive acts; v and g do not jump with it.
        const auto sample_until = [&](TimePoint time) {
            for (; sample < at_ns.size() && time_point(at_ns[sample]) <= time; ++sample) {
                const TimePoint at = time_point(at_ns[sample]);
                advance(at);
                for (std::uint32_t i = 0; i < drives.neurons; ++i) {
                    const auto state = population.state(i, at);
                    traces.states.push_back({neuron.v_mv(state), neuron.g(state)});
                }
            }
        };
        for (std::size_t row = 0; row < drives.times_ns.size(); ++row) {
            const TimePoint time = time_point(drives.times_ns[row]);
            if (time > until) break;
            sample_until(time);
            advance(time);
            for (std::uint32_t i = 0; i < drives.neurons; ++i)
                population.set_drive(i, time, drives.drives_mv[row * drives.neurons + i]);
        }
        sample_until(until);
        // By short spans, so that it can be interrupted.
        for (TimePoint time = drives.times_ns.empty() ? scene_start : time_point(drives.times_ns.back());
             time < until; time += std::min<Duration>(until - time, 1s))
            advance(time);
        advance(until);
    });
    return traces;
}

void require_rising(std::span<const std::int64_t> times_ns, const char* name) {
    for (std::size_t i = 0; i < times_ns.size(); ++i)
        if (times_ns[i] < (i == 0 ? 0 : times_ns[i - 1]))
            throw py::value_error(std::string(name) + " must be sorted and begin at 0 or later");
}

std::span<const std::int64_t> span_of(const Times& times) {
    return {times.data(), static_cast<std::size_t>(times.size())};
}

py::tuple run_neurons(const NeuronModel& model, const Times& times_ns, const Numbers& drives_mv,
                      std::int64_t until_ns, const std::optional<Times>& at_ns) {
    if (times_ns.ndim() != 1 || drives_mv.ndim() != 2 || drives_mv.shape(0) != times_ns.size())
        throw py::value_error("drives: a row for each time; there are " + std::to_string(times_ns.size()) +
                              " times");
    const Drives drives{span_of(times_ns),
                        {drives_mv.data(), static_cast<std::size_t>(drives_mv.size())},
                        static_cast<std::size_t>(drives_mv.shape(1))};
    require_rising(drives.times_ns, "times");
    for (const double drive_mv : drives.drives_mv)
        if (!std::isfinite(drive_mv)) throw py::value_error("drives must be finite");
    const std::span<const std::int64_t> at = at_ns ? span_of(*at_ns) : std::span<const std::int64_t>();
    require_rising(at, "at");
    if (!at.empty() && at.back() > until_ns) throw py::value_error("at must not be after until");
    if (until_ns < 0) throw py::value_error("until must not be negative");
    auto traces = std::make_unique<Traces>();
    Watch watch{py::none()};
    {
        const py::gil_scoped_release unlocked;
        *traces = carry_out(model, drives, time_point(until_ns), at, watch);
    }
    Traces& rows = *traces;
    const py::capsule owner = owner_of(std::move(traces));
    const py::dtype states = row_dtype(
        {{"v_mv", "f8", offsetof(StateRow, v_mv)}, {"g", "f8", offsetof(StateRow, g)}}, sizeof(StateRow));
    return py::make_tuple(
        rows_in_place(event_dtype(), rows.events, owner),
        py::array(states, {at.size(), drives.neurons}, {drives.neurons * sizeof(StateRow), sizeof(StateRow)},
                  rows.states.data(), owner));
}

struct BoundNeuron {
    NeuronModel model;
};

}  // namespace

void bind_neuron(py::module_& module) {
    py::class_<BoundNeuron>(module, "Neuron")
        .def(py::init([](const Scene& scene, std::size_t patch) {
                 const Plan plan = make_plan(scene);
                 if (patch >= plan.patches.size())
                     throw py::index_error("the scene has " + std::to_string(plan.patches.size()) +
                                           " patches");
                 return BoundNeuron{plan.patches[patch].neuron};
             }),
             py::arg("scene"), py::arg("patch"))
        .def(
            "rate_hz",
            [](const BoundNeuron& self, const Numbers& drive_mv, const std::string& kind) {
                return for_each_number(drive_mv, [&, of = rate_kind(kind)](double drive) {
                    return afferent::rate_hz(of, self.model, drive);
                });
            },
            py::arg("drive_mv"), py::arg("kind"))
        .def(
            "drive_mv",
            [](const BoundNeuron& self, const Numbers& rate_hz, const std::string& kind) {
                for (py::ssize_t i = 0; i < rate_hz.size(); ++i)
                    if (!(rate_hz.data()[i] > 0)) throw py::value_error("rate_hz must be > 0");
                return for_each_number(rate_hz, [&, of = rate_kind(kind)](double rate) {
                    return afferent::drive_mv(of, self.model, rate);
                });
            },
            py::arg("rate_hz"), py::arg("kind"))
        .def_property_readonly("rheobase_mv", [](const BoundNeuron& self) { return rheobase_mv(self.model); })
        .def_property_readonly("model", [](const BoundNeuron& self) { return name(self.model); })
        .def("__repr__", [](const BoundNeuron& self) { return "Neuron(" + describe(self.model) + ")"; })
        .def(
            "run",
            [](const BoundNeuron& self, const Times& times_ns, const Numbers& drives_mv,
               std::int64_t until_ns, const std::optional<Times>& at_ns) {
                return run_neurons(self.model, times_ns, drives_mv, until_ns, at_ns);
            },
            py::arg("times_ns"), py::arg("drives_mv"), py::arg("until_ns"), py::arg("at_ns") = py::none());
}

}  // namespace afferent::python
