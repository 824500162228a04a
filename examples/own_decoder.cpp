// A decoder of one's own beside a coprocessor. Each afferent tells a force by its last interval, and their
// median stands, so that an element that is stuck or wild does not move the estimate.
#include <afferent/decoders/decoder.hpp>
#include <afferent/engine/controller.hpp>
#include <afferent/engine/coprocessor.hpp>
#include <algorithm>
#include <cstdio>
#include <vector>

using namespace afferent;

class MedianInterval {
  public:
    struct Parameters {
        Duration silence = 200ms;  // an afferent that has been silent for so long feels nothing
    };
    struct Heard {
        TimePoint last;
        double force_n = 0;  // what its last interval tells
        double rate_hz = 0;
        bool fired = false;
    };
    struct Snapshot {
        std::vector<Heard> heard;  // for each address
        TimePoint known_from, heard_until;
        Estimate last;
    };

    MedianInterval(const Parameters& parameters, const DecodedAfferents& afferents)
        : parameters_(parameters), afferents_(afferents) {
        afferents_.check();
        forces_n_.reserve(afferents_.afferents.size());
        restart(scene_start);
    }

    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
        if (begin > state_.heard_until) lose(state_.heard_until, begin);
        for (const DecodedAfferents::Afferent& afferent : afferents_.afferents)
            for (const Event& event : events)
                if (event.address == afferent.address) hear(afferent, event.time);
        state_.heard_until = end;
    }
    // What comes after a gap is no interval: it would be too long.
    void lose(TimePoint, TimePoint end) {
        std::ranges::fill(state_.heard, Heard());
        state_.known_from = state_.heard_until = end;
    }
    void presume_silence(TimePoint) {}
    TimePoint heard_until() const { return state_.heard_until; }

    Estimate estimate(TimePoint now) {
        if (now < state_.known_from + parameters_.silence) {  // nobody could have been silent for long enough
            state_.last.sigma_n = afferents_.largest_grip_n;
            state_.last.doubt = Doubt::unknown;
            return state_.last;
        }
        state_.last = {};
        forces_n_.clear();
        for (const DecodedAfferents::Afferent& afferent : afferents_.afferents) {
            const Heard& heard = state_.heard[afferent.address];
            const bool silent = now - heard.last > parameters_.silence;
            forces_n_.push_back(silent ? 0 : heard.force_n);
            state_.last.rate_hz +=
                silent ? 0 : heard.rate_hz / static_cast<double>(afferents_.afferents.size());
        }
        state_.last.force_n = median();
        for (double& force_n : forces_n_) force_n = std::abs(force_n - state_.last.force_n);
        state_.last.sigma_n = 1.4826 * median();  // that of a normal distribution
        return state_.last;
    }
    Duration history() const { return 2 * parameters_.silence; }

    void restart(TimePoint start) { resume_after(start, start, {}); }
    void resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) {
        state_ = {std::vector<Heard>(afferents_.addresses), start, heard_until, last};
    }
    void correct(const Estimate& last) { state_.last = last; }
    Snapshot snapshot() const { return state_; }
    void resume(const Snapshot& snapshot) { state_ = snapshot; }
    std::size_t bytes() const { return sizeof *this + state_.heard.capacity() * sizeof(Heard); }

  private:
    void hear(const DecodedAfferents::Afferent& afferent, TimePoint time) {
        Heard& heard = state_.heard[afferent.address];
        if (heard.fired && time > heard.last) {
            heard.rate_hz = 1 / seconds(time - heard.last);
            heard.force_n = afferents_.groups[afferent.group].grip_n(RateKind::steady, heard.rate_hz);
        }
        heard.fired = true;
        heard.last = time;
    }
    double median() {
        const auto middle = forces_n_.begin() + static_cast<std::ptrdiff_t>(forces_n_.size() / 2);
        std::nth_element(forces_n_.begin(), middle, forces_n_.end());
        return *middle;
    }

    Parameters parameters_;
    DecodedAfferents afferents_;
    std::vector<double> forces_n_;
    Snapshot state_;
};

static_assert(Decoder<MedianInterval>);

int main() {
    Scene scene;
    scene.patches = {{.name = "thumb", .elements = 5}};
    scene.source = scene::Pushed();
    scene.decoder.kind = scene::InverseInterval();

    Coprocessor coprocessor(scene);
    // What the library's own decoders are told: neurons, gains and shares of the afferents.
    MedianInterval mine({}, decoded_afferents(scene));
    Controller theirs(scene);
    const Emg at_rest{User::rest_counts, User::rest_counts};
    for (TimePoint now = scene_start; now < scene_start + 3s; now += 5ms) {
        const double grip_n = std::min(10.0, 10 * seconds(now));
        const double each_n = grip_n / 5;
        const double forces_n[] = {each_n, each_n, each_n, each_n, 9};  // the last element is stuck at 9 N
        coprocessor.push({now, 0, forces_n});
        const TimePoint end = now + 5ms;
        const auto events = coprocessor.advance(end - 1ns);
        mine.observe(now, end, events);
        theirs.observe(now, end, events);
        const Estimate estimate = mine.estimate(end);
        std::printf("%.3f s: grip %.2f N, median %.2f N, sigma %.2f N; interval %.2f N\n", seconds(end),
                    grip_n, estimate.force_n, estimate.sigma_n, theirs.step(end, at_rest).estimate.force_n);
    }
}
