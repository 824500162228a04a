#include "afferent/scene/plan_parts.hpp"

namespace afferent {
namespace {

std::string number(double value) {
    std::string text = std::to_string(value);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text;
}

struct TransportName {
    std::string operator()(const scene::InProcess&) const { return "in process"; }
    std::string operator()(const scene::UnixSocket& at) const { return "Unix socket " + at.path; }
    std::string operator()(const scene::Tcp& at) const {
        return "TCP " + at.host + ":" + std::to_string(at.port);
    }
    std::string operator()(const scene::Udp& at) const {
        return "UDP " + at.host + ":" + std::to_string(at.port);
    }
    std::string operator()(const scene::Serial& at) const {
        return "serial line " + at.device + ", " + std::to_string(at.baud) + " baud";
    }
    std::string operator()(const scene::File& at) const { return "file " + at.path; }
    std::string operator()(const scene::NamedPipes& at) const { return "named pipes " + at.path; }
};

struct DriveReason {
    std::string operator()(const Sustained::Parameters&) const { return "drive in proportion to force"; }
    std::string operator()(const Transient::Parameters&) const {
        return "drive in proportion to its rate of change";
    }
    std::string operator()(const BandTransient::Parameters& band) const {
        return "drive in proportion to its rate of change, most at " + number(band.corner_hz) + " Hz";
    }
    std::string operator()(const Vibration::Parameters& band) const {
        return "drive in proportion to the change of its rate of change, most at " + number(band.corner_hz) +
               " Hz";
    }
};

class Parts {
  public:
    explicit Parts(const Plan& plan) : plan_(plan), link_(plan.scene.link) {}

    std::vector<Plan::Part> all() {
        for (const PatchPlan& patch : plan_.patches) add_patch(patch);
        add("address-event bus", plan_.bus.has_value(),
            plan_.bus ? "link.bus: at most " + number(1 / seconds(plan_.bus->cycle)) +
                            " events per second, of " + std::to_string(plan_.bus->rows) + " rows"
                      : "events reach the link as they are fired");
        add_table();
        add_link();
        add_controller();
        const scene::Record& record = plan_.scene.record;
        add("recording of events", record.events, "record.events");
        add("recording of force", record.force, "record.force");
        add("picture", record.picture, "record.picture");
        add("skipping of overdue scans", plan_.skip_scans_after.has_value(),
            plan_.skip_scans_after
                ? "runtime.skip_scans_after_ms: in real time, when " +
                      number(Milliseconds(*plan_.skip_scans_after).count()) + " ms behind the clock"
                : "in real time, everything is computed, however late");
        add("worker threads", plan_.threads > 1,
            plan_.threads > 1
                ? "the scene is worth " + std::to_string(plan_.threads) + " threads"
                : std::to_string(plan_.addresses) + " neurons are less work than waking a thread");
        return std::move(parts_);
    }

  private:
    void add(std::string name, bool built, std::string reason) {
        parts_.push_back({std::move(name), built, std::move(reason)});
    }

    void add_patch(const PatchPlan& patch) {
        const std::string about = "patch \"" + patch.name + "\": ";
        add(about + "sensors", patch.owns_elements,
            patch.owns_elements ? std::to_string(patch.elements()) + " elements"
                                : "it reads those of \"" + plan_.patches[patch.reads].name + "\"");
        add(about + "receptive fields", !patch.fields.is_one_each(),
            patch.fields.is_one_each()
                ? "each afferent reads an element of its own"
                : std::to_string(patch.afferents()) + " afferents with rows of weights");
        add(about + "two dimensions", patch.grid.has_value() || !patch.places.empty(), layout(patch));
        add(about + name(patch.encoder) + " encoder", true, std::visit(DriveReason(), patch.encoder));
        const std::string differ = differences(patch);
        add(about + "spread", !differ.empty(),
            differ.empty() ? "spread is not given: afferents are alike" : "afferents differ in " + differ);
        add(about + forms(patch.form), true, patch.form_reason);
        add(about + "adaptation", adaptation(patch.neuron) > 0,
            "delta_g is " + number(adaptation(patch.neuron)));
        add(about + "refractory period", refractory(patch.neuron) > Milliseconds(0),
            "refractory_ms is " + number(refractory(patch.neuron).count()));
        if (patch.owns_elements)
            add(about + "noise", patch.sensor.noise_counts > 0,
                "sensor.noise_counts is " + number(patch.sensor.noise_counts));
    }

    static const char* forms(scene::Form form) {
        switch (form) {
            case scene::Form::sparse:
                return "neurons, by prediction";
            case scene::Form::dense:
                return "neurons, by a sweep per scan";
            case scene::Form::automatic:
                break;
        }
        return "neurons, by prediction, and by a sweep per scan where much happens";
    }

    static std::string layout(const PatchPlan& patch) {
        std::string reason;
        if (patch.grid) reason = "elements in a grid of " + number(patch.grid->pitch_mm()) + " mm";
        if (!patch.places.empty())
            reason += (reason.empty() ? "" : ", ") + std::to_string(patch.places.size()) +
                      " afferents at places of their own";
        return reason.empty() ? "outline is not given" : reason;
    }

    std::string differences(const PatchPlan& patch) const {
        const auto index = static_cast<std::size_t>(&patch - plan_.patches.data());
        const scene::Spread& spread = plan_.scene.patches[index].spread;
        std::string all;
        const auto tell = [&](bool given, const char* what) {
            if (given) all += (all.empty() ? "" : ", ") + std::string(what);
        };
        tell(spread.gain.has_value(), "gain");
        tell(spread.threshold.has_value(), "threshold");
        tell(spread.delta_g.has_value(), "delta_g");
        tell(spread.field_sd.has_value() && !patch.places.empty(), "field_sd");
        tell(spread.phase.has_value(), "phase");
        tell(!spread.time_class.empty(), "time constants");
        return all;
    }

    void add_table() {
        const auto* table = std::get_if<scene::Table>(&plan_.scene.source);
        if (const auto* crossing = std::get_if<scene::LinkSource>(&plan_.scene.source))
            table = &crossing->table;
        const bool linear = table && table->between == scene::Between::linear;
        add("samples between the rows of a table", linear,
            !table   ? "the samples are no table in a file"
            : linear ? "between is LINEAR: where rows are further apart than samples"
                     : "between is HOLD: a row is held until the next");
    }

    void add_link() {
        const std::string transport = std::visit(TransportName(), link_.transport);
        add("packets and codec", plan_.packets.has_value(),
            plan_.packets ? "the link leaves the process: " + transport
                          : "the link is in process: events are handed over");
        add("keys", link_.keys.has_value(),
            !link_.keys ? "link.keys is not given: the link does not leave the machine"
            : !plan_.over_datagrams
                ? "link.keys: TLS 1.3, both certificates pinned"
                : "link.keys: DTLS, both certificates pinned; each datagram sealed with ChaCha20-Poly1305");
        add("channel", link_.channel.has_value(),
            link_.channel ? "link.channel is between the two sides: afferent channel, or a run's own"
                          : "link.channel is not given: nothing is lost or delayed on purpose");
        if (!plan_.packets || std::holds_alternative<scene::File>(link_.transport)) return;
        add("refusal of stale packets", true,
            "older than " + number(Milliseconds(plan_.timing.stale).count()) + " ms when they come");
        add("watch for silence", true,
            "no closing after " + number(link_.freeze_ms) + " ms, safe state after " + number(link_.safe_ms) +
                " ms");
        const bool by_user = plan_.scene.hand.rearm == Rearm::by_user;
        add("acknowledgement by the user", by_user,
            by_user ? "hand.rearm is BY_USER: a safe hand operates again when its user says so"
                    : "hand.rearm is NEW_SESSION: a new session re-arms a safe hand");
    }

    void add_controller() {
        const bool decoder = plan_.controller.has_value();
        add("decoder and gain", decoder,
            decoder ? "the estimate is recorded or moves the hand" : "nobody reads the estimate");
        const bool parts = decoder && !plan_.controller->parts.empty();
        add("decoders of parts", parts,
            parts ? "decoder.parts: " + std::to_string(plan_.controller->parts.size()) +
                        " of them, beside the grip's"
                  : "decoder.parts is NONE: the grip alone is estimated");
        add_readouts("contact", decoder ? plan_.controller->readouts.contacts : std::vector<ReadoutOfPatch>(),
                     "decoder.contact is not given");
        add_readouts("edges", decoder ? plan_.controller->readouts.edges : std::vector<ReadoutOfPatch>(),
                     "decoder.edge is not given");
        const bool filter = decoder && std::holds_alternative<scene::Filter>(plan_.scene.decoder.kind);
        add("uncertainty of the sensors", filter,
            filter    ? known(plan_.scene.uncertainty)
            : decoder ? "decoder is not the filter, whose sigma alone contains it"
                      : "nobody reads the estimate");
        const double sigmas = plan_.scene.gain.upper_bound_sigmas;
        const bool by_bound = plan_.scene.gain.doubtful == EmgGain::Doubtful::by_upper_bound;
        add("gain by an upper bound", decoder && sigmas > 0,
            !decoder     ? "nobody reads the estimate"
            : sigmas > 0 ? "gain.upper_bound_sigmas: of the force and " + number(sigmas) + " sigma"
            : by_bound
                ? "gain.upper_bound_sigmas is 0: only that of a doubtful estimate is by its upper bound"
                : "gain.doubtful is AS_ESTIMATED: the gain is that of the estimate");
        const std::string& unreachable = plan_.unreachable_limit;
        if (!unreachable.empty())
            add("gain of 0 at the limit", false, "gain.accept_unreachable_limit, although " + unreachable);
        add("commands in a file", !plan_.scene.output.empty(),
            plan_.scene.output.empty() ? "output is not given" : "output.command_file");
        add("simulated motor and object", plan_.gripper.has_value(),
            plan_.gripper ? "the samples are of the simulated hand"
                          : "open loop: the samples come from elsewhere");
        const bool table = plan_.scene.hand.emg_table.has_value();
        add("simulated user", decoder && !table,
            table     ? "the EMG is a table"
            : decoder ? "there is no EMG table"
                      : "nobody reads the EMG");
    }

    // What the decoder takes for known, and how well.
    static std::string known(const Uncertainty& of) {
        const auto percent = [](double part) { return number(100 * part) + " %"; };
        return "uncertainty: gains within " + percent(of.gain) + " each and " + percent(of.common_gain) +
               " in common, shares within " + percent(of.share) + " over " + number(of.share_time_s) +
               " s, zeros within " + number(of.offset_n) + " N, hysteresis within " + percent(of.hysteresis) +
               ", adaptation within " + percent(of.adaptation);
    }

    void add_readouts(const std::string& what, const std::vector<ReadoutOfPatch>& readouts,
                      const char* none) {
        if (readouts.empty()) return add("read-out of " + what, false, none);
        for (const ReadoutOfPatch& each : readouts)
            add("read-out of " + what + ", \"" + plan_.patches[each.patch].name + "\"", each.built,
                each.reason);
    }

    const Plan& plan_;
    const scene::Link& link_;
    std::vector<Plan::Part> parts_;
};

}  // namespace

std::vector<Plan::Part> parts_of(const Plan& plan) { return Parts(plan).all(); }

}  // namespace afferent
