// The two ends of a scene as a program embeds them, and the decoder by itself.
#include <cstring>

#include "afferent/engine/controller.hpp"
#include "afferent/engine/coprocessor.hpp"
#include "afferent/python/bindings.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent::python {
namespace {

Plan plan_with_controller(const Scene& scene, Commands commands) {
    const py::gil_scoped_release unlocked;
    return make_plan(scene, commands);
}

class BoundCoprocessor : public Exclusive {
  public:
    explicit BoundCoprocessor(const Plan& plan) : coprocessor(plan), elements(plan.elements), plan_(plan) {}

    void push(std::int64_t time_ns, const Numbers& forces_n, std::uint32_t first) {
        require_free();
        const auto count = static_cast<std::size_t>(forces_n.size());
        if (count > elements || first > elements - count)
            throw py::value_error("forces_n: the scene has " + std::to_string(elements) + " elements, and " +
                                  std::to_string(count) + " forces from element " + std::to_string(first) +
                                  " on do not fit");
        coprocessor.push({time_point(time_ns), first, {forces_n.data(), count}});
    }

    py::array advance(std::int64_t until_ns) {
        const std::span<const Event> events =
            without_lock([&] { return coprocessor.advance(time_point(until_ns)); });
        // They stay where they are until the next call only.
        py::array copy(event_dtype(), static_cast<py::ssize_t>(events.size()));
        if (!events.empty()) std::memcpy(copy.mutable_data(), events.data(), events.size_bytes());
        return copy;
    }

    Coprocessor coprocessor;
    std::size_t elements;

  private:
    Plan plan_;
};

// Spans come in the order of time.
template <class Decoding>
void require_span(const Decoding& decoding, TimePoint begin, TimePoint end) {
    if (end < begin) throw py::value_error("end_ns must not be before begin_ns");
    if (begin < decoding.heard_until())
        throw py::value_error("begin_ns must not be before " + std::to_string(ns(decoding.heard_until())) +
                              ", where the last span ended");
}

class BoundController : public Exclusive {
  public:
    explicit BoundController(const Plan& plan) : addresses(plan.addresses), controller(plan) {}

    void observe(std::int64_t begin_ns, std::int64_t end_ns, const py::array& events) {
        const EventArray array(events);
        without_lock([&] {
            require_span(controller, time_point(begin_ns), time_point(end_ns));
            require_within(array.span(), time_point(begin_ns), time_point(end_ns), addresses);
            controller.observe(time_point(begin_ns), time_point(end_ns), array.span());
        });
    }
    void lose(std::int64_t begin_ns, std::int64_t end_ns) {
        without_lock([&] {
            require_span(controller, time_point(begin_ns), time_point(end_ns));
            controller.lose(time_point(begin_ns), time_point(end_ns));
        });
    }
    void receive(const py::bytes& frame) {
        const std::string_view bytes = frame;
        without_lock([&] { value_or_throw(controller.receive(std::as_bytes(std::span(bytes)))); });
    }
    py::bytes acknowledgement() {
        const auto frame = without_lock([&] { return controller.acknowledgement(); });
        return {reinterpret_cast<const char*>(frame.data()), frame.size()};
    }
    ControllerStep step(std::int64_t now_ns, double closing_counts, double opening_counts) {
        return without_lock([&] {
            if (time_point(now_ns) < controller.last_step().time)
                throw py::value_error("now_ns must not be before that of the last step");
            return controller.step(time_point(now_ns), {closing_counts, opening_counts});
        });
    }

    std::uint32_t addresses;
    Controller controller;
};

// With a name of its own in Python: a variant is what one of its alternatives is.
struct DecoderSnapshot {
    GripDecoder::Snapshot decoder;
    TimePoint last;
};

class BoundDecoder : public Exclusive {
  public:
    explicit BoundDecoder(const Plan& plan)
        : addresses(plan.addresses), decoder(plan.controller->decoder, plan.controller->afferents) {}

    void observe(std::int64_t begin_ns, std::int64_t end_ns, const py::array& events) {
        const EventArray array(events);
        without_lock([&] {
            require_span(decoder, time_point(begin_ns), time_point(end_ns));
            require_within(array.span(), time_point(begin_ns), time_point(end_ns), addresses);
            decoder.observe(time_point(begin_ns), time_point(end_ns), array.span());
        });
    }
    void lose(std::int64_t begin_ns, std::int64_t end_ns) {
        without_lock([&] {
            require_span(decoder, time_point(begin_ns), time_point(end_ns));
            decoder.lose(time_point(begin_ns), time_point(end_ns));
        });
    }
    Estimate estimate(std::int64_t now_ns) {
        return without_lock([&] {
            const TimePoint now = time_point(now_ns);
            if (now < decoder.heard_until() || now < last)
                throw py::value_error(
                    "now_ns must not be before the last span's end, nor before the last estimate");
            last = now;
            return decoder.estimate(now);
        });
    }
    void restart(std::int64_t start_ns) {
        require_free();
        last = time_point(start_ns);
        decoder.restart(last);
    }

    std::uint32_t addresses;
    GripDecoder decoder;
    TimePoint last = scene_start;
};

constexpr const char* state_names[]{"operating", "frozen", "safe"};
static_assert(static_cast<int>(GripState::safe) == 2);

GripState state_of(const std::string& name) {
    for (int i = 0; i < 3; ++i)
        if (name == state_names[i]) return static_cast<GripState>(i);
    throw py::value_error("state must be operating, frozen or safe, is " + name);
}

}  // namespace

void bind_embedding(py::module_& module) {
    py::class_<BoundCoprocessor>(module, "Coprocessor")
        .def(py::init([](const Scene& scene) {
                 const py::gil_scoped_release unlocked;
                 return std::make_unique<BoundCoprocessor>(make_plan(scene));
             }),
             py::arg("scene"))
        .def("push", &BoundCoprocessor::push, py::arg("time_ns"), py::arg("forces_n"), py::arg("first") = 0)
        .def("advance", &BoundCoprocessor::advance, py::arg("until_ns"))
        .def("reset",
             [](BoundCoprocessor& self) {
                 self.require_free();
                 self.coprocessor.reset();
             })
        .def_property_readonly("now_ns",
                               [](const BoundCoprocessor& self) { return ns(self.coprocessor.now()); })
        .def_property_readonly("elements", [](const BoundCoprocessor& self) { return self.elements; })
        .def_property_readonly("late_scans",
                               [](const BoundCoprocessor& self) { return self.coprocessor.late_scans(); })
        .def_property_readonly("refused_samples", [](const BoundCoprocessor& self) {
            return self.coprocessor.refused_samples();
        });

    py::class_<Estimate>(module, "Estimate")
        .def_readonly("force_n", &Estimate::force_n)
        .def_readonly("sigma_n", &Estimate::sigma_n)
        .def_readonly("rate_hz", &Estimate::rate_hz)
        .def_readonly("left_out", &Estimate::left_out)
        .def_property_readonly("doubt", [](const Estimate& estimate) { return name(estimate.doubt); })
        .def("__repr__", [](const Estimate& estimate) {
            return py::str(
                       "Estimate(force_n={:.3f}, sigma_n={:.3f}, rate_hz={:.1f}, left_out={}, doubt='{}')")
                .format(estimate.force_n, estimate.sigma_n, estimate.rate_hz, estimate.left_out,
                        name(estimate.doubt));
        });

    py::class_<ControllerStep>(module, "Step")
        .def_property_readonly("time_ns", [](const ControllerStep& self) { return ns(self.time); })
        .def_property_readonly("estimate", [](const ControllerStep& self) { return self.estimate; })
        .def_property_readonly("force_n", [](const ControllerStep& self) { return self.estimate.force_n; })
        .def_property_readonly("sigma_n", [](const ControllerStep& self) { return self.estimate.sigma_n; })
        .def_property_readonly("rate_hz", [](const ControllerStep& self) { return self.estimate.rate_hz; })
        .def_property_readonly("gain", [](const ControllerStep& self) { return self.gain; })
        .def_property_readonly("command", [](const ControllerStep& self) { return self.command; })
        .def_property_readonly("parts",
                               [](const ControllerStep& self) {
                                   std::vector<Estimate> parts;
                                   for (const PartForce& part : self.parts) parts.push_back(part.estimate);
                                   return parts;
                               })
        .def("__repr__", [](const ControllerStep& self) {
            return py::str("Step(time_ns={}, force_n={:.3f}, sigma_n={:.3f}, gain={:.3f}, command={:.3f})")
                .format(ns(self.time), self.estimate.force_n, self.estimate.sigma_n, self.gain, self.command);
        });

    // Opaque: a value to continue from.
    const py::class_<Controller::Snapshot> controller_snapshot(module, "ControllerSnapshot");
    const py::class_<DecoderSnapshot> decoder_snapshot(module, "DecoderSnapshot");

    py::class_<BoundController>(module, "Controller")
        .def(py::init([](const Scene& scene) {
                 return std::make_unique<BoundController>(plan_with_controller(scene, Commands::wanted));
             }),
             py::arg("scene"))
        .def("observe", &BoundController::observe, py::arg("begin_ns"), py::arg("end_ns"), py::arg("events"))
        .def("lose", &BoundController::lose, py::arg("begin_ns"), py::arg("end_ns"))
        .def("receive", &BoundController::receive, py::arg("frame"))
        .def("acknowledgement", &BoundController::acknowledgement)
        .def(
            "step",
            [](BoundController& self, std::int64_t now_ns, double closing_counts, double opening_counts) {
                return ControllerStep(self.step(now_ns, closing_counts, opening_counts));
            },
            py::arg("now_ns"), py::arg("closing_counts") = User::rest_counts,
            py::arg("opening_counts") = User::rest_counts)
        .def(
            "restart",
            [](BoundController& self, std::int64_t now_ns) {
                self.require_free();
                self.controller.restart(time_point(now_ns));
            },
            py::arg("now_ns"))
        .def(
            "left_out",
            [](const BoundController& self, std::uint32_t address) {
                self.require_free();
                return self.controller.left_out(address);
            },
            py::arg("address"))
        .def("snapshot",
             [](const BoundController& self) {
                 self.require_free();
                 return self.controller.snapshot();
             })
        .def(
            "resume",
            [](BoundController& self, const Controller::Snapshot& snapshot) {
                self.require_free();
                self.controller.resume(snapshot);
            },
            py::arg("snapshot"))
        .def_property(
            "state",
            [](const BoundController& self) {
                return state_names[static_cast<int>(self.controller.state())];
            },
            [](BoundController& self, const std::string& state) {
                self.require_free();
                self.controller.set_state(state_of(state));
            })
        .def_property_readonly("heard_until_ns",
                               [](const BoundController& self) { return ns(self.controller.heard_until()); });

    py::class_<BoundDecoder>(module, "Decoder")
        .def(py::init([](const Scene& scene) {
                 return std::make_unique<BoundDecoder>(plan_with_controller(scene, Commands::recorded));
             }),
             py::arg("scene"))
        .def("observe", &BoundDecoder::observe, py::arg("begin_ns"), py::arg("end_ns"), py::arg("events"))
        .def("lose", &BoundDecoder::lose, py::arg("begin_ns"), py::arg("end_ns"))
        .def(
            "presume_silence",
            [](BoundDecoder& self, std::int64_t until_ns) {
                self.require_free();
                self.decoder.presume_silence(time_point(until_ns));
            },
            py::arg("until_ns"))
        .def("estimate", &BoundDecoder::estimate, py::arg("now_ns"))
        .def("restart", &BoundDecoder::restart, py::arg("start_ns"))
        .def(
            "left_out",
            [](const BoundDecoder& self, std::uint32_t address) { return self.decoder.left_out(address); },
            py::arg("address"))
        .def("snapshot",
             [](const BoundDecoder& self) {
                 self.require_free();
                 return DecoderSnapshot{self.decoder.snapshot(), self.last};
             })
        .def(
            "resume",
            [](BoundDecoder& self, const DecoderSnapshot& snapshot) {
                self.require_free();
                self.decoder.resume(snapshot.decoder);
                self.last = snapshot.last;
            },
            py::arg("snapshot"))
        .def_property_readonly("heard_until_ns",
                               [](const BoundDecoder& self) { return ns(self.decoder.heard_until()); })
        .def_property_readonly("history_ns",
                               [](const BoundDecoder& self) { return self.decoder.history().count(); });
}

}  // namespace afferent::python
