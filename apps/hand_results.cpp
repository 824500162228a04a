#include "afferent/apps/hand_results.hpp"

#include <chrono>
#include <utility>

#include "afferent/apps/failure.hpp"
#include "afferent/nodes/hand_report.hpp"
#include "afferent/nodes/run_summary.hpp"

namespace afferent {
namespace {

// How many pictures are drawn of a hand that starts over again and again.
constexpr std::size_t most_pictures = 10;

// Packets whose events wait to be drawn.
constexpr std::size_t room_for_events = 1024;

constexpr std::chrono::milliseconds pause_between_writes{5};
constexpr std::chrono::seconds patience{2};

void add_force_errors(Summary& summary, const Recorder& recorder) {
    summary["force_error_rms_n"] = or_null(recorder.error().rms_n());
    summary["force_error_max_n"] = or_null(recorder.error().max_n());
    recorder.add_readouts(summary);
}

}  // namespace

HandResults::HandResults(const Plan& plan, std::string out, FullPipe full_pipe)
    : plan_(plan), out_(std::move(out)), full_pipe_(full_pipe), events_(room_for_events) {
    start_recorder();
}

HandResults::~HandResults() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
}

void HandResults::start_recorder() {
    recorders_.push_back(std::make_unique<Recorder>(plan_, session_folder(out_, ++starts_),
                                                    Recorder::Ends{.coprocessor = false, .hand = true},
                                                    full_pipe_));
}

void HandResults::step(const ControllerStep& step) {
    recorders_.back()->step(step);
    ++progress_;
}

void HandResults::events(std::span<const Event> events) {
    if (out_.empty()) return;
    if (!thread_.joinable()) return recorders_.back()->events(events);
    // These events are for the picture only: those that find no room are not drawn.
    if (EventsOfPacket* const slot = events_.free_slot()) {
        slot->events.assign(events.begin(), events.end());
        events_.push();
    }
}

void HandResults::about_to_start_over(const HandNode& node) {
    const std::scoped_lock lock(mutex_);
    before_.push_back(summary_of(node));
}

void HandResults::starting_over() {
    Summary before;
    {
        const std::scoped_lock lock(mutex_);
        if (!before_.empty()) {
            before = std::move(before_.front());
            before_.pop_front();
        }
    }
    guarded([&] {
        add_force_errors(before, *recorders_.back());
        recorders_.back()->close(before);
    });
    if (recorders_.size() > most_pictures) recorders_.pop_back();
    guarded([&] { start_recorder(); });
    if (failure_) {
        // Later sessions cannot be written either.
        out_.clear();
        start_recorder();
    }
}

void HandResults::guarded(const std::function<void()>& write) {
    try {
        write();
    } catch (const Failure& failure) {
        if (!failure_) failure_ = failure.what();
    }
}

void HandResults::start_thread(HandNode& node) {
    thread_ = std::thread([this, &node] {
        while (!ends_) {
            write_some(node);
            ++progress_;
            std::this_thread::sleep_for(pause_between_writes);
        }
        write_some(node);
        if (summary_) complete(node);
        done_ = true;
    });
}

void HandResults::write_some(HandNode& node) {
    node.write();
    while (const EventsOfPacket* packet = events_.next()) {
        recorders_.back()->events(packet->events);
        events_.pop();
        ++progress_;
    }
}

void HandResults::complete(HandNode& node) {
    Summary& summary = *summary_;
    Recorder& recorder = *recorders_.back();
    add_force_errors(summary, recorder);
    const auto count = [&] {
        summary["unwritten_steps"] =
            node.report().unwritten_steps + node.lost_steps() + recorder.unwritten_steps();
        ++progress_;
    };
    guarded([&] { value_or_fail(node.close()); });
    count();
    guarded([&] {
        recorder.close_tables();
        count();
        recorder.close(summary);
    });
    count();
}

bool HandResults::finish(HandNode& node, Summary& summary) {
    summary_ = std::move(summary);
    if (thread_.joinable()) {
        ends_ = true;
        auto last = std::chrono::steady_clock::now();
        for (std::uint64_t seen = progress_; !done_;) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            const auto now = std::chrono::steady_clock::now();
            if (const std::uint64_t progress = progress_; progress != seen) {
                seen = progress;
                last = now;
            }
            if (now - last < patience) continue;
            summary = summary_of(node);
            summary["unwritten_steps"] = node.report().unwritten_steps + node.waiting_records();
            return false;
        }
        thread_.join();
    } else {
        complete(node);
    }
    summary = std::move(*summary_);
    return true;
}

std::vector<std::string> HandResults::draw_pictures() {
    std::vector<std::string> undrawn;
    for (const auto& recorder : recorders_)
        if (auto reason = recorder->draw_pictures()) undrawn.push_back(*std::move(reason));
    return undrawn;
}

}  // namespace afferent
