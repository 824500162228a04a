// afferent emulate: an emulated hand on a pseudo-terminal, for those who have none.
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <memory>
#include <vector>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/print_at_once.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/hand/ability_hand_emulator.hpp"
#include "afferent/io/links/pseudo_terminal.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

using Clock = std::chrono::steady_clock;

struct EmulateOptions {
    SceneOptions scene;
    double noise = 0;
    double freeze_at_s = 0;
    double press_n = 0;
    bool json = false;
};

AbilityHandEmulator::Parameters emulator_parameters(const Scene& scene, double noise) {
    const double each = noise / 5;
    return {.address = static_cast<std::uint8_t>(scene.hand.ability_hand->address),
            .baud = scene.hand.ability_hand->baud,
            .stiffness_n_per_mm = scene.hand.object.stiffness_n_per_mm,
            .distance_mm = scene.hand.object.distance_mm,
            .breaking_n = scene.gain.limit_n,
            .noise = {each, each, each, each, each},
            .seed = scene.seed};
}

// Says how it goes, once a second, where people look.
class Telling {
  public:
    void look_at(const AbilityHandEmulator& hand, TimePoint now) {
        if (!is_terminal_ || now < next_) return;
        next_ = now + 1s;
        std::fprintf(stderr, "\r%6.1f s: index at %5.1f deg, grip %5.2f N, at most %5.2f N, %s  ",
                     seconds(now), hand.position_deg(0), hand.grip_n(), hand.highest_grip_n(),
                     hand.driven() ? "driven" : "stands");
    }
    ~Telling() {
        if (next_ > scene_start) std::fputc('\n', stderr);
    }

  private:
    bool is_terminal_ = ::isatty(STDERR_FILENO) != 0;
    TimePoint next_ = scene_start;
};

void run_emulator(const EmulateOptions& options) {
    catch_interrupts();
    const Scene scene = options.scene.read();
    if (!scene.hand.ability_hand)
        throw Failure(scene.file + ": the scene has no hand.ability_hand to emulate");
    boost::asio::io_context io;
    const std::string path = scene.resolve(scene.hand.ability_hand->port).string();
    auto terminal = value_or_fail(NamedTerminal::open(io, path));
    auto line = terminal.take_ours();
    line.non_blocking(true);
    AbilityHandEmulator hand(emulator_parameters(scene, options.noise));
    hand.faults().pressing_n = options.press_n;
    say("an emulated hand is at " + path + ", until Ctrl-C; beside it: afferent hand " + scene.file);

    const auto began = Clock::now();
    const auto now = [began] { return scene_start + Duration(Clock::now() - began); };
    std::vector<std::byte> in(512);
    std::vector<std::byte> out;
    {
        Telling telling;
        while (!interrupted()) {
            hand.faults().frozen = options.freeze_at_s > 0 && seconds(now()) >= options.freeze_at_s;
            const Duration due = hand.next_reply() ? *hand.next_reply() - now() : 10ms;
            const timespec limit{.tv_sec = 0, .tv_nsec = std::clamp<Duration>(due, {}, 10ms).count()};
            pollfd waited{.fd = line.native_handle(), .events = POLLIN, .revents = 0};
            if (::ppoll(&waited, 1, &limit, nullptr) > 0) {
                const ssize_t count = ::read(line.native_handle(), in.data(), in.size());
                if (count > 0) hand.receive(now(), std::span(in).first(static_cast<std::size_t>(count)));
            }
            hand.advance(now());
            out.clear();
            hand.send(now(), out);
            // What the terminal has no room for is lost, as on a line that nobody reads.
            if (!out.empty() && ::write(line.native_handle(), out.data(), out.size()) < 0 && errno != EAGAIN)
                throw Failure(path + ": the line has failed");
            telling.look_at(hand, now());
        }
    }
    Summary summary;
    summary["requests"] = hand.requests();
    summary["refused_frames"] = hand.refused_frames();
    summary["damaged_replies"] = hand.damaged_replies();
    summary["highest_grip_n"] = hand.highest_grip_n();
    summary["broken"] = hand.broken();
    print(summary, options.json);
}

}  // namespace

Command emulate_command() {
    const auto options = std::make_shared<EmulateOptions>();
    return {
        .name = "emulate",
        .help = "Be the hand of a scene on a pseudo-terminal: for those who have no such hand",
        .footer =
            "It stands at the port of hand.ability_hand until Ctrl-C, which ends it with 0, and then says "
            "how hard it has "
            "gripped.\n"
            "Example, in two terminals:\n  afferent emulate examples/ability_hand.txtpb\n  afferent hand "
            "examples/ability_hand.txtpb",
        .options = options->scene.followed_by({
            option("--noise", options->noise,
                   "Probability that a reply is damaged: its beginning or end lost, nulls, a flipped bit, or "
                   "nothing")
                .within(0, 1),
            option("--freeze-at", options->freeze_at_s, "From this time on, in seconds, it answers nothing")
                .within(0, 1e9),
            option("--press", options->press_n, "Force on its sensors from outside, in N").within(0, 100),
            flag("--json", options->json, "Print the summary as JSON"),
        }),
        .run = [options] { run_emulator(*options); },
    };
}

}  // namespace afferent
