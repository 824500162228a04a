#include "bench/closed_loop.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <map>
#include <mutex>
#include <random>
#include <thread>

#include "afferent/engine/controller.hpp"
#include "afferent/engine/coprocessor.hpp"
#include "afferent/hand/gripper.hpp"
#include "afferent/hand/user.hpp"
#include "afferent/neurons/rate.hpp"
#include "afferent/nodes/patch_sensors.hpp"
#include "afferent/runtime/parallel.hpp"
#include "afferent/scene/plan.hpp"
#include "bench/table_file.hpp"

namespace afferent {
namespace {

constexpr double tolerated_n = 1;
// Sensors that are further off than this factor are not allowed for.
constexpr double most_told = 1.5;

class Draw {
  public:
    explicit Draw(std::uint64_t seed, std::uint64_t index) : random_(seed * 1'000'003 + index) {}

    template <class T, std::size_t N>
    T of(const T (&values)[N]) {
        return values[std::uniform_int_distribution<std::size_t>(0, N - 1)(random_)];
    }
    double between(double lowest, double highest) {
        return std::uniform_real_distribution<double>(lowest, highest)(random_);
    }
    // Uniform in the logarithm of the factor.
    double factor(double lowest, double highest) {
        return std::exp(between(std::log(lowest), std::log(highest)));
    }
    double normal(double sd) { return std::normal_distribution<double>(0, sd)(random_); }

  private:
    std::mt19937_64 random_;
};

// To two significant digits, which are easy to read.
double rounded_off(double value) {
    const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
    return std::round(value / unit) * unit;
}

scene::Decoder draw_decoder(Draw& draw) {
    scene::Decoder decoder;
    switch (draw.of({0, 1, 2, 3, 4, 5})) {
        case 0:
            decoder.kind = scene::SlidingWindow{draw.of({30.0, 60.0, 120.0})};
            break;
        case 1:
            decoder.kind = scene::Exponential{draw.of({20.0, 40.0, 80.0})};
            break;
        case 2:
            decoder.kind = scene::InverseInterval();
            break;
        case 3:
            decoder.kind = scene::Inversion();
            break;
        case 4:
            decoder.kind = scene::Filter();
            break;
        case 5:
            decoder.kind = scene::Filter();
            decoder.parts = scene::Parts::elements;
            break;
    }
    decoder.pooling = draw.of({Pooling::pooled, Pooling::pooled, Pooling::per_neuron});
    return decoder;
}

Scene draw_scene(Draw& draw) {
    Scene scene;
    scene.duration_s = 4.5;
    scene.patches = {{.name = "grip", .elements = draw.of({1U, 3U, 9U})}};
    scene::Patch& patch = scene.patches.front();
    patch.sensor.full_scale_n = rounded_off(draw.factor(1, 25));
    patch.sensor.hysteresis = draw.of({0.0, 0.0, 0.03});
    if (patch.elements > 1 && draw.of({false, true})) {
        double sum = 0;
        for (std::uint32_t i = 0; i < patch.elements; ++i) {
            patch.share.push_back(draw.between(0.5, 1.5));
            sum += patch.share.back();
        }
        // Rounded down, so that they are no more than 1.
        for (double& share : patch.share) share = std::floor(1000 * share / sum) / 1000;
    }
    patch.neuron.tau_g_ms = draw.of({100.0, 200.0, 500.0});
    patch.neuron.delta_g = draw.of({0.03, 0.06, 0.2});
    patch.neuron.tuning = {.rate = draw.of({RateKind::steady, RateKind::onset}),
                           .rate_hz = draw.of({30.0, 60.0, 100.0, 200.0}),
                           .force_n = draw.of({10.0, 20.0, 40.0})};
    scene.source = scene::SimulatedHand();
    scene.decoder = draw_decoder(draw);
    scene.gain.limit_n = draw.of({5.0, 10.0, 15.0});
    scene.gain.lambda_n = draw.of({2.0, 3.0, 4.0});
    scene.gain.shape = draw.of({EmgGain::Shape::exponential, EmgGain::Shape::continuous});
    scene.gain.upper_bound_sigmas = draw.of({0.0, 0.0, 2.0});
    scene.gain.accept_unreachable_limit = true;
    scene.hand.user = {.close_at_s = 0.2,
                       .close_for_s = 3,
                       .hold_for_s = 1.3,
                       .open_for_s = 0,
                       .effort = draw.of({0.3, 0.5, 0.9}),
                       .ramp_s = draw.of({0.1, 0.3})};
    scene.hand.motor = {.time_constant_ms = draw.of({40.0, 60.0}),
                        .speed_mm_per_s = draw.of({40.0, 80.0}),
                        .force_limit_n = draw.of({25.0, 60.0})};
    scene.hand.object = {.stiffness_n_per_mm = rounded_off(draw.factor(0.3, 3)),
                         .distance_mm = draw.of({5.0, 15.0})};
    return scene;
}

// The real sensors and neurons: those of the plan, changed by what the scene says wrongly.
std::vector<PatchPlan> true_patches(const Plan& plan, const ClosedLoop& loop) {
    std::vector<PatchPlan> patches = plan.patches;
    for (PatchPlan& patch : patches) {
        for (std::uint32_t i = 0; i < patch.elements(); ++i) patch.share[i] *= loop.gains[i];
        patch.sensor.dead_element = loop.dead;
        patch.sensor.hysteresis = loop.hysteresis;
        std::get<LifParameters>(patch.neuron).tau_g_ms *= loop.tau_g;
    }
    return patches;
}

// The mean steady rate of the afferents at a grip force, as their sensors feel it while it is loaded.
double steady_rate_hz(const PatchPlan& patch, double grip_n) {
    double sum_hz = 0;
    for (std::uint32_t i = 0; i < patch.elements(); ++i) {
        const auto& dead = patch.sensor.dead_element;
        if (std::ranges::find(dead, i) != dead.end()) continue;
        const double felt_n =
            std::min(patch.share[i] * grip_n * (1 - patch.sensor.hysteresis), patch.sensor.full_scale_n);
        sum_hz += rate_hz(RateKind::steady, patch.neuron, patch.gain() * felt_n + patch.bias_mv());
    }
    return sum_hz / patch.elements();
}

// The grip force at which the real afferents fire as the told ones do at the limit. The told sensors have no
// hysteresis here, as in the curves of decoders.
double told_limit_n(PatchPlan told, const PatchPlan& real, double limit_n) {
    told.sensor.hysteresis = 0;
    told.sensor.full_scale_n = std::numeric_limits<double>::infinity();
    const double wanted_hz = steady_rate_hz(told, limit_n);
    double least_n = limit_n;
    double most_n = most_told * limit_n;
    PatchPlan unclipped = real;
    unclipped.sensor.full_scale_n = told.sensor.full_scale_n;
    if (steady_rate_hz(unclipped, least_n) >= wanted_hz) return least_n;
    for (int i = 0; i < 40; ++i) {
        const double middle_n = (least_n + most_n) / 2;
        (steady_rate_hz(unclipped, middle_n) < wanted_hz ? least_n : most_n) = middle_n;
    }
    return most_n;
}

const char* decoder_name(const scene::Decoder& decoder) {
    if (decoder.parts != scene::Parts::none) return "filter with parts";
    constexpr std::array names{"window", "exponential", "interval", "inversion", "filter"};
    return names[decoder.kind.index()];
}

// The highest force of a hand that keeps its command for `told_after` and then stops.
double momentum_n(Gripper hand, double command, Duration told_after) {
    double highest_n = hand.force_n();
    for (Duration t{}; t < told_after + 1s; t += 1ms) {
        hand.advance(t < told_after ? command : 0, 1ms);
        highest_n = std::max(highest_n, hand.force_n());
    }
    return highest_n;
}

}  // namespace

ClosedLoop draw_closed_loop(std::uint64_t seed, std::uint64_t index) {
    Draw draw(seed, index);
    for (;;) {
        ClosedLoop loop{.told = draw_scene(draw), .refusal = {}, .wrong = {}, .gains = {}, .dead = {}};
        loop.told.name = "loop " + std::to_string(index);
        loop.told.seed = index + 1;
        const std::uint32_t elements = loop.told.patches.front().elements;
        loop.gains.assign(elements, 1);
        loop.hysteresis = loop.told.patches.front().sensor.hysteresis;
        switch (draw.of({0, 0, 0, 1, 2, 3, 4, 5})) {
            case 0:
                loop.wrong = "nothing";
                break;
            case 1: {
                loop.wrong = "gains";
                const double sd = draw.of({0.05, 0.1});
                for (double& gain : loop.gains) gain = 1 + std::clamp(draw.normal(sd), -2 * sd, 2 * sd);
                break;
            }
            case 2: {
                loop.wrong = "shares";
                double sum = 0;
                for (double& gain : loop.gains) sum += gain = draw.between(0.8, 1.2);
                for (double& gain : loop.gains) gain *= elements / sum;
                break;
            }
            case 3:
                loop.wrong = "tau_g";
                loop.tau_g = draw.of({0.8, 1.2});
                break;
            case 4:
                loop.wrong = elements > 3 ? "dead" : "nothing";
                if (elements > 3) loop.dead = {draw.of({0U, 4U}), draw.of({7U, 8U})};
                break;
            case 5:
                loop.wrong = "hysteresis";
                loop.hysteresis = draw.of({0.05, 0.08});
                break;
        }
        try {
            (void)make_plan(loop.told);
        } catch (const SceneError&) {
            continue;  // such as neurons that cannot be tuned so
        }
        Scene asking = loop.told;
        asking.gain.accept_unreachable_limit = false;
        try {
            asking.check();
        } catch (const SceneError& error) {
            loop.refusal = error.what();
        }
        return loop;
    }
}

const char* ClosedLoopResult::coverage() const noexcept {
    if (full_scale_n < limit_n) return "below the limit";
    return full_scale_n < 1.3 * limit_n ? "hardly above" : "30 % to spare";
}

ClosedLoopResult run_closed_loop(const ClosedLoop& loop) {
    Plan plan = make_plan(loop.told);
    Controller controller(plan);
    const std::vector<PatchPlan> patches = true_patches(plan, loop);
    const PatchPlan& patch = patches.front();
    ClosedLoopResult result{.decoder = decoder_name(loop.told.decoder),
                            .elements = plan.elements,
                            .limit_n = loop.told.gain.limit_n,
                            .full_scale_n = plan.controller->afferents.largest_grip_n,
                            .reach = gain_reach(plan.controller->gain_loop()),
                            .told_limit_n = told_limit_n(plan.patches.front(), patch, loop.told.gain.limit_n),
                            .peak_n = 0,
                            .momentum_n = 0,
                            .above_s = 0};
    plan.patches = patches;
    Coprocessor coprocessor(plan);
    PatchSensors sensors(patch, loop.told.seed);
    Gripper hand(*plan.gripper);
    const User user(loop.told.hand.user, loop.told.seed);
    const Duration packet = plan.timing.packet;
    const Duration told_after =
        patch.scan_interval + packet + plan.timing.delivery + from_milliseconds(loop.told.hand.envelope_ms);

    struct Packet {
        TimePoint begin;
        std::vector<Event> events;
    };
    std::vector<Packet> under_way;
    TimePoint closed = scene_start;
    TimePoint next_scan = scene_start;
    double command = 0;
    for (std::uint64_t k = 0; scene_start + static_cast<Duration::rep>(k) * 1ms < plan.end(); ++k) {
        const TimePoint now = scene_start + static_cast<Duration::rep>(k) * 1ms;
        if (k > 0) hand.advance(command, 1ms);
        if (closed + packet <= now) {
            // The events of a packet end before it does.
            const auto events = coprocessor.advance(closed + packet - Duration(1));
            under_way.push_back({closed, {events.begin(), events.end()}});
            closed += packet;
        }
        if (next_scan <= now) {
            coprocessor.push({now, 0, sensors.feel(hand.force_n())});
            next_scan += patch.scan_interval;
        }
        while (!under_way.empty() && under_way.front().begin + packet + plan.timing.delivery <= now) {
            const Packet& arrived = under_way.front();
            controller.observe(arrived.begin, arrived.begin + packet, arrived.events);
            under_way.erase(under_way.begin());
        }
        const ControllerStep& step = controller.step(now, user.emg(now, k));
        command = step.command;
        const double force_n = hand.force_n();
        result.peak_n = std::max(result.peak_n, force_n);
        if (force_n <= result.told_limit_n) continue;
        if (result.momentum_n == 0) result.momentum_n = momentum_n(hand, command, told_after);
        if (force_n > result.momentum_n + tolerated_n && step.gain > 0) result.above_s += 1e-3;
    }
    return result;
}

std::vector<ClosedLoopRow> search_closed_loops(std::uint64_t seed, std::uint64_t count,
                                               const std::function<void(double)>& progress) {
    std::vector<ClosedLoopRow> rows(count);
    std::mutex reporting;
    std::size_t done = 0;
    Workers(std::max(1U, std::thread::hardware_concurrency())).run(count, [&](std::size_t i) {
        rows[i].loop = draw_closed_loop(seed, i);
        rows[i].result = run_closed_loop(rows[i].loop);
        const std::lock_guard lock(reporting);
        progress(static_cast<double>(++done) / static_cast<double>(count));
    });
    return rows;
}

void write_closed_loops(const std::vector<ClosedLoopRow>& rows, const std::filesystem::path& folder) {
    bench::TableFile file(
        folder / "closed_loop.csv",
        {"loop", "decoder", "elements", "limit_n", "full_scale_n", "sensed_n", "wanted_n", "rate_hz",
         "closes_n", "wrong", "accepted", "told_limit_n", "momentum_n", "peak_n", "above_s", "bad"});
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto& [loop, result] = rows[i];
        file.row({std::to_string(i), result.decoder, std::to_string(result.elements),
                  bench::number(result.limit_n), bench::number(result.full_scale_n),
                  bench::number(result.reach.sensed_n), bench::number(result.reach.wanted_n),
                  bench::number(result.reach.rate_hz),
                  result.reach.closes_n ? bench::number(*result.reach.closes_n) : "", loop.wrong,
                  loop.refusal.empty() ? "1" : "0", bench::number(result.told_limit_n),
                  bench::number(result.momentum_n), bench::number(result.peak_n),
                  bench::number(result.above_s), result.bad() ? "1" : "0"});
    }
    file.close();
}

void print_closed_loops(const std::vector<ClosedLoopRow>& rows, std::ostream& out) {
    struct Count {
        std::uint64_t accepted = 0, bad = 0, refused = 0, refused_good = 0;
    };
    std::map<std::pair<std::string, std::string>, Count> counts;
    for (const auto& [loop, result] : rows) {
        Count& count = counts[{result.decoder, result.coverage()}];
        ++(loop.refusal.empty() ? count.accepted : count.refused);
        if (loop.refusal.empty() && result.bad()) ++count.bad;
        if (!loop.refusal.empty() && !result.bad()) ++count.refused_good;
    }
    out << "\nRandom closed loops: the force more than " << tolerated_n
        << " N beyond its limit and the hand's momentum for over 0.1 s, with the gain open\n  " << std::left
        << std::setw(20) << "decoder" << std::setw(17) << "sensors reach" << std::right << std::setw(10)
        << "accepted" << std::setw(10) << "of them" << std::setw(10) << "refused" << std::setw(12)
        << "without need" << '\n';
    for (const auto& [key, count] : counts)
        out << "  " << std::left << std::setw(20) << key.first << std::setw(17) << key.second << std::right
            << std::setw(10) << count.accepted << std::setw(10) << count.bad << std::setw(10) << count.refused
            << std::setw(12) << count.refused_good << '\n';
    for (const auto& [loop, result] : rows)
        if (loop.refusal.empty() && result.bad())
            out << "  " << result.above_s << " s, up to " << result.peak_n << " N, " << loop.wrong
                << " not as told: " << loop.told.text() << '\n';
}

}  // namespace afferent
