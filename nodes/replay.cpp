#include "afferent/nodes/replay.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "afferent/io/wire/printable.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// Packets of a hand in lockstep are ahead of it by less than this.
constexpr Duration lead = 500ms;

bool within(std::int64_t time_ns, const Plan& plan) {
    return time_ns >= 0 && Duration(time_ns) <= plan.end() - scene_start;
}

GripState grip_state(proto::GripState state) {
    return state == proto::SAFE     ? GripState::safe
           : state == proto::FROZEN ? GripState::frozen
                                    : GripState::operating;
}

// Where a replay that begins at `from` starts to read, so that the decoder's window is whole at the last mark
// before `from`: at the mark `first`; or nothing, at the beginning. `second` is that last mark. Marks come in
// the order of the file.
struct Marks {
    RecordedMark first;
    std::optional<RecordedMark> second;
};
std::optional<Marks> marks_before(TimePoint from, Duration needed, const std::vector<RecordedMark>& marks) {
    const auto after = std::find_if(marks.begin(), marks.end(),
                                    [from](const RecordedMark& mark) { return mark.time >= from; });
    if (after == marks.begin()) return std::nullopt;
    const auto last = after - 1;
    for (auto mark = last; mark != marks.begin();) {
        --mark;
        if (mark->time <= last->time - needed) return Marks{*mark, *last};
        // A hand that had started over then knew nothing from before.
        if (mark->time >= (mark + 1)->time) return Marks{*mark, std::nullopt};
    }
    return std::nullopt;
}

}  // namespace

Result<std::unique_ptr<Replay>> Replay::open(const std::filesystem::path& file, Observer observer,
                                             const std::optional<scene::Decoder>& decoder,
                                             const Scene* outputs) {
    auto reader = RecordingReader::open(file);
    if (!reader) return reader.error();
    try {
        // Tables are in the recording: no path of the scene is looked up.
        const std::string name = file.string();
        Scene scene = Scene::from_text(reader.value().head().scene(), name);
        Plan plan = make_plan(scene, Commands::recorded);
        std::optional<Plan> other_plan;
        if (decoder) {
            scene.decoder.kind = decoder->kind;
            // Which takes the filter.
            if (!is_filter(*decoder)) scene.decoder.contact.reset();
            other_plan = make_plan(scene, Commands::recorded);
        }
        std::unique_ptr<Replay> replay(new Replay(std::move(plan), std::move(other_plan), name,
                                                  std::move(reader.value()), std::move(observer)));
        if (outputs) {
            AFFERENT_TRY(opened, Outputs::open(*outputs));
            replay->outputs_ = std::move(opened);
        }
        return replay;
    } catch (const SceneError& error) {
        return Error{Error::Kind::malformed, error.what()};
    }
}

Replay::Replay(Plan plan, std::optional<Plan> other_plan, std::string file, RecordingReader reader,
               Observer observer)
    : plan_(std::move(plan)),
      other_plan_(std::move(other_plan)),
      file_(std::move(file)),
      reader_(std::move(reader)),
      observer_(std::move(observer)) {}

Result<void> Replay::begin_from(TimePoint time) {
    from_ = time;
    // What spikes are foreseen follows from all packets before.
    if (plan_.packets && plan_.packets->encoding == Encoding::predicted) return success();
    const auto marks = reader_.marks();
    if (!marks) return marks.error();
    // How far back the decoders remember.
    const Duration history = std::max(Controller(plan_).history(), Controller(plan()).history());
    const auto found = marks_before(time, history + plan_.timing.delivery + lead, marks.value());
    if (!found) return success();
    // The EMG comes before all sessions.
    for (;;) {
        const Result<bool> read = reader_.next(entry_);
        if (!read) return read.error();
        if (!read.value() || !entry_.has_emg()) break;
        if (const Result<void> taken = take_emg(entry_.emg()); !taken) return taken;
    }
    if (found->second) correcting_mark_ = found->second->time;
    return resume_at(found->first);
}

Result<void> Replay::resume_at(const RecordedMark& mark) {
    if (const Result<void> gone = reader_.go_to(mark); !gone) return gone;
    const Result<bool> read = reader_.next(entry_);
    if (!read) return read.error();
    if (const Result<void> made = make_end(); !made) return made;
    const proto::Mark& told = entry_.mark();
    const bool plausible = within(told.time_ns(), plan_) && within(told.heard_until_ns(), plan_) &&
                           told.presumes_from_ns() >= 0 &&
                           told.presumes_from_ns() <= told.time_ns() + plan_.timing.distrust.count() &&
                           entry_.step() > 0 && told.first_step() < entry_.step() &&
                           sample_time(entry_.step() - 1, plan_.scene.hand.emg_rate_hz) == mark.time;
    if (!plausible) return malformed("a mark is of no time of the scene");
    receiver_.emplace(packet_layout(plan_));
    receiver_->resume(told.position(), told.counted_events());
    begun_ = true;
    counts_.sessions = 1;
    link_end_->resume({.time = mark.time,
                       .first_step = told.first_step(),
                       .next_step = entry_.step(),
                       .heard_until = scene_start + Duration(told.heard_until_ns()),
                       .presumes_from = scene_start + Duration(told.presumes_from_ns()),
                       .estimate = {},
                       .command = 0,
                       .gripper = {},
                       .state = state_ = grip_state(told.state())});
    const auto first = correcting_mark_;
    correcting_mark_ = mark.time;
    const Result<void> taken = take_mark(told);
    correcting_mark_ = first;
    return taken;
}

Result<std::optional<TimePoint>> Replay::next() {
    for (;;) {
        if (const Result<void> taken = take_what_is_due(); !taken) return taken.error();
        if (!link_end_) return std::optional<TimePoint>();
        const TimePoint time = link_end_->next_step_time();
        if (time >= end_of_scene() || (end_step_ && link_end_->next_step() >= *end_step_))
            return std::optional<TimePoint>();
        // A recording that was not closed ends when the last of its packets has acted.
        if (all_read_ && !end_step_ && time >= end_.value_or(acted_until_)) return std::optional<TimePoint>();
        if (time >= from_) return std::optional(time);
        step();
    }
}

void Replay::step() {
    const bool silent = link_end_->next_step_time() < from_;
    bool has_stepped = false;
    while (!has_stepped) {
        [[maybe_unused]] const bool done = link_end_->do_next(
            [&](const ControllerStep& step) {
                has_stepped = true;
                now_ = step.time;
                last_estimate_ = step.estimate;
                if (silent) return;
                ControllerStep& told = told_step_;
                told = step;
                if (!told.true_force_n) {
                    told.true_force_n = recorded() == proto::RUN
                                            ? stated_grip_n(plan_.scene.source, step.time)
                                            : std::nullopt;
                    if (!told.true_force_n) told.true_force_n = true_force_n_;
                    tell_shares(plan_, told);
                    for (std::size_t i = 0; i < true_part_n_.size(); ++i)
                        told.parts[i].true_force_n = true_part_n_[i];
                }
                outputs_.take(told);
                observer_.step(told);
            },
            [](const Scan&) {});
        assert(done);
    }
}

Result<void> Replay::take_what_is_due() {
    for (;;) {
        if (!has_entry_ && !all_read_) {
            const Result<bool> read = reader_.next(entry_);
            if (!read) return read.error();
            has_entry_ = read.value();
            all_read_ = !has_entry_;
        }
        if (!has_entry_ || comes_later()) return success();
        has_entry_ = false;
        if (const Result<void> taken = take(); !taken) return taken;
    }
}

// An entry without a step acts at its regular time. It may be taken before that: it waits on the hand's end.
bool Replay::comes_later() const {
    // At the scene's end there are no further steps, and what is left is taken at once.
    if (!link_end_ || link_end_->next_step_time() >= end_of_scene()) return false;
    if (!reader_.head().has_steps()) return acted_until_ > link_end_->next_step_time();
    return entry_.has_step() && entry_.step() > link_end_->next_step();
}

Result<void> Replay::take() {
    switch (entry_.kind_case()) {
        case proto::Entry::kHead:
            return malformed("has a second head");
        case proto::Entry::kEmg:
            return take_emg(entry_.emg());
        case proto::Entry::kLink:
            return take_message(entry_.link());
        case proto::Entry::kBegin:
            return take_begin(entry_.begin());
        case proto::Entry::kGrip:
            take_grip(entry_.grip());
            return success();
        case proto::Entry::kTrueForce:
            true_force_n_ = entry_.true_force().force_n();
            return take_true_parts(entry_.true_force().part_n());
        case proto::Entry::kMark:
            return take_mark(entry_.mark());
        case proto::Entry::kEnd:
            if (entry_.has_step()) end_step_ = entry_.step();
            end_ = scene_start + Duration(entry_.end().time_ns());
            return success();
        case proto::Entry::kIndex:
        case proto::Entry::KIND_NOT_SET:
            return success();
    }
    return malformed("has an entry of a later version");
}

Result<void> Replay::take_emg(const proto::EmgSamples& samples) {
    if (link_end_ || samples.gap_ns_size() != samples.counts_size() || !plan_.scene.hand.emg_table)
        return malformed("has EMG where none can be");
    if (samples.has_rest_counts()) {
        if (!std::isfinite(samples.rest_counts())) return malformed("has EMG that cannot be");
        emg_.rest_counts = samples.rest_counts();
    }
    for (int i = 0; i < samples.counts_size(); ++i) {
        const TimePoint last = emg_.times.empty() ? scene_start : emg_.times.back();
        const std::int64_t gap_ns = samples.gap_ns(i);
        constexpr std::int64_t longest_ns = std::int64_t{1} << 61;
        if (gap_ns > longest_ns || gap_ns < -longest_ns || (!emg_.times.empty() && gap_ns < 0) ||
            last.time_since_epoch().count() > longest_ns || !std::isfinite(samples.counts(i)))
            return malformed("has EMG that cannot be");
        emg_.times.push_back(last + Duration(gap_ns));
        emg_.counts.push_back(samples.counts(i));
    }
    return success();
}

Result<void> Replay::take_message(const proto::Envelope& message) {
    if (message.has_hello()) {
        if (message.hello().scene_fingerprint() != plan_.scene.fingerprint())
            return malformed("a session is of another scene than the recording's");
        counts_ = counts();
        receiver_.emplace(packet_layout(plan_));
        begun_ = false;
        ++counts_.sessions;
        return success();
    }
    if (!receiver_) return malformed("has packets before any hello");
    if (message.has_bye()) {
        const std::int64_t time_ns = message.bye().time_ns();
        if (time_ns < 0 || time_ns >= std::int64_t{1} << 62) return malformed("a bye is of no time");
        if (const auto gap = receiver_->finish(scene_start + Duration(time_ns), message.bye().events()))
            give({.gap = gap, .known = {gap->end, gap->end}, .events = {}, .more = false});
        return success();
    }
    // What the recorded hand has refused is refused and counted here, too: for its time, where it holds
    // nothing wrong.
    const TimePoint latest = entry_.refused() ? scene_start - 1ns : TimePoint::max();
    if (const Result<Reception> received = receiver_->receive(message, latest)) {
        Reception reception = received.value();
        reception.stale = entry_.stale();
        give(reception.usable() ? reception : receiver_->discard(reception));
    }
    return success();
}

void Replay::give(const Reception& reception) {
    if (reception.gap && reception.gap->end > from_) observer_.gap(*reception.gap);
    if (reception.known.end > from_) {
        outputs_.observe(reception.known, reception.events);
        observer_.events(reception.events);
    }
    if (!link_end_ || !begun_) return;
    if (entry_.has_step())
        counts_.late += entry_.stale() ? 0 : 1;
    else
        acted_until_ = std::max(acted_until_, reception.known.end + plan_.timing.delivery);
    link_end_->receive(reception);
}

Result<void> Replay::take_begin(const proto::Begin& begin) {
    if (!within(begin.time_ns(), plan_)) return malformed("begins outside of its scene");
    const TimePoint time = scene_start + Duration(begin.time_ns());
    begun_ = true;
    if (link_end_ && !begin.new_hand()) {
        link_end_->restart(time);
        link_end_->set_state(state_);
        return success();
    }
    if (link_end_) observer_.starting_over();
    if (const Result<void> made = make_end(); !made) return made;
    link_end_->begin_at(time);
    link_end_->set_state(state_);
    true_force_n_.reset();
    true_part_n_.clear();
    acted_until_ = time;
    return success();
}

Result<void> Replay::make_end() {
    if (plan_.scene.hand.emg_table && emg_.times.empty())
        return malformed("has no EMG, though its scene has a table of it");
    try {
        link_end_ = HandEnd::replaying(plan_, emg_);
        if (other_plan_) link_end_->tell_steps_of(*other_plan_);
    } catch (const ParameterError& error) {
        return malformed(error.what());
    }
    return success();
}

Result<void> Replay::take_mark(const proto::Mark& mark) {
    if (correcting_mark_ != scene_start + Duration(mark.time_ns())) return success();
    correcting_mark_.reset();
    for (const double value : {mark.force_n(), mark.sigma_n(), mark.rate_hz(), mark.command()})
        if (!std::isfinite(value)) return malformed("a mark has what is not a number");
    if (mark.doubt() > static_cast<std::uint32_t>(last_doubt))
        return malformed("a mark has a doubt that this version does not know");
    HandEnd::Memory memory = link_end_->memory();
    memory.time = scene_start + Duration(mark.time_ns());
    memory.estimate = {.force_n = mark.force_n(),
                       .sigma_n = mark.sigma_n(),
                       .rate_hz = mark.rate_hz(),
                       .doubt = static_cast<Doubt>(mark.doubt())};
    memory.command = mark.command();
    memory.gripper = {mark.gripper_mm(), mark.gripper_mm_per_s()};
    link_end_->correct(memory);
    if (!mark.has_true_force_n() || plan_.gripper) return success();
    true_force_n_ = mark.true_force_n();
    return take_true_parts(mark.true_part_n());
}

Result<void> Replay::take_true_parts(const google::protobuf::RepeatedField<double>& forces_n) {
    if (!forces_n.empty() && forces_n.size() != static_cast<int>(plan_.controller->parts.size()))
        return malformed("has true forces of other parts than its scene");
    true_part_n_.assign(forces_n.begin(), forces_n.end());
    return success();
}

void Replay::take_grip(const proto::Grip& grip) {
    state_ = grip_state(grip.state());
    // Before there is an end, the entry gives the state in which the hand begins.
    if (!link_end_) return;
    link_end_->set_state(state_);
    if (state_ == GripState::frozen) ++counts_.freezes;
    if (state_ == GripState::safe) {
        ++counts_.safe_states;
        observer_.safe(printable(grip.reason()));
    }
}

ReplayCounts Replay::counts() const {
    ReplayCounts sum = counts_;
    if (!receiver_) return sum;
    const PacketCounts& session = receiver_->counts();
    sum.packets += session.packets;
    sum.events += session.events;
    sum.gaps += session.gaps;
    sum.lost_events += session.lost_events;
    sum.out_of_order += session.out_of_order;
    sum.refused += session.refused;
    return sum;
}

}  // namespace afferent
