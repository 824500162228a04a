// Faults that involve the kernel: real processes that are killed and stopped, idle connections, a terminal
// that takes nothing.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <fstream>
#include <functional>
#include <regex>
#include <string>
#include <thread>

#include "afferent/nodes/hello.hpp"
#include "bench/attackers.hpp"
#include "tests/apps/process.hpp"
#include "tests/long_runs.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

using std::chrono::milliseconds;

class Processes : public testing::TestWithParam<const char*> {
  protected:
    Processes() {
        write_scene();
        if (has_keys()) {
            Process keys({"keys", folder_("keys")});
            EXPECT_EQ(keys.wait(), 0) << keys.err();
        }
    }

    static std::string transport() { return GetParam(); }
    static bool has_keys() { return transport() == "tls" || transport() == "udp_sealed"; }
    void write_scene(const std::string& more_of_the_hand = "") const {
        const auto port = std::to_string(20'000 + ::getpid() % 10'000);
        const std::string link = transport() == "unix"            ? "unix_socket { path: 'hand.sock' }"
                                 : transport().starts_with("udp") ? "udp { port: " + port + " }"
                                                                  : "tcp { port: " + port + " }";
        // A seed of its own: the status of a scene is asked for by its fingerprint.
        write_file(scene(),
                   "duration_s: 200 seed: " + std::to_string(::getpid()) + " link { " + link + " " +
                       less_patient + (has_keys() ? " keys: 'keys'" : "") +
                       " } hand { user { close_at_s: 0 close_for_s: 200 } object { distance_mm: 500 } " +
                       more_of_the_hand + " }");
    }

    std::string scene() const { return folder_("scene.txtpb"); }
    const Folder& folder() const { return folder_; }
    std::unique_ptr<Process> start(const char* link_end) const {
        return std::make_unique<Process>(std::vector<std::string>{link_end, scene(), "--json"});
    }

    // What the hand says of itself.
    std::string status(const std::string& key) const {
        Process status({"link", "status", scene(), "--json"});
        status.wait();
        std::smatch found;
        const std::string out = status.out();
        return std::regex_search(out, found, std::regex('"' + key + "\": ?\"([^\"]+)\"")) ? found[1].str()
                                                                                          : "";
    }
    // A process that is held up may not answer in time, so it is asked again.
    std::string grip_state() const {
        std::string state;
        EXPECT_TRUE(comes_true([&] { return !(state = status("grip_state")).empty(); }));
        return state;
    }
    // Within a generous time: how long it takes is for tests in virtual time.
    bool becomes(const std::string& state) const { return comes_to_say("grip_state", state); }
    bool comes_to_say(const std::string& key, const std::string& value) const {
        return comes_true([&] { return status(key) == value; });
    }
    // The user acknowledges until it does: on a busy machine a hand may have gone safe once more.
    bool operates_when_acknowledged(Process& hand) const {
        for (int i = 0; i < 100; ++i) {
            hand.signal(SIGUSR1);
            std::this_thread::sleep_for(milliseconds(100));
            if (grip_state() == "operating") return true;
        }
        return false;
    }

    // What an attacker knows of the hand.
    struct Attacked {
        explicit Attacked(const Processes& test)
            : plan(make_plan(Scene::from_file(test.scene()), Commands::wanted)),
              victim{plan, transport() == "unix" ? test.folder()("hand.sock") : "",
                     static_cast<std::uint16_t>(20'000 + ::getpid() % 10'000),
                     value_or_throw(hand_address(plan.scene, LinkEnd::coprocessor))} {}
        Attacked(const Attacked&) = delete;
        Attacked& operator=(const Attacked&) = delete;

        Plan plan;
        bench::Victim victim;
    };

    static void expect_little_memory(const Process& hand) {
        std::ifstream status("/proc/" + std::to_string(hand.id()) + "/status");
        double peak_kb = 0;
        for (std::string word; status >> word && word != "VmHWM:";) {
        }
        status >> peak_kb;
        EXPECT_GT(peak_kb, 0);
#ifdef NDEBUG  // what a sanitizer needs is another matter
        EXPECT_LT(peak_kb, 64 * 1024);
#endif
    }

  private:
    Folder folder_;
};

TEST_P(Processes, AKilledCoprocessorMakesSafeAndTheNextOneReArms) {
    const auto hand = start("hand");
    ASSERT_TRUE(hand->has_said("waiting")) << hand->err();
    auto coprocessor = start("coprocessor");
    ASSERT_TRUE(becomes("operating")) << hand->err();
    coprocessor->signal(SIGKILL);
    EXPECT_TRUE(becomes("safe")) << hand->err();
    coprocessor = start("coprocessor");
    EXPECT_TRUE(becomes("operating")) << hand->err() << coprocessor->err();
}

TEST_P(Processes, AnInterruptedCoprocessorDoesNotEndTheHand) {
    const auto hand = start("hand");
    ASSERT_TRUE(hand->has_said("waiting")) << hand->err();
    auto coprocessor = start("coprocessor");
    ASSERT_TRUE(becomes("operating")) << hand->err();
    coprocessor->signal(SIGTERM);
    coprocessor->wait();
    EXPECT_TRUE(becomes("safe")) << hand->err();
    coprocessor = start("coprocessor");
    EXPECT_TRUE(becomes("operating")) << hand->err() << coprocessor->err();
}

TEST_P(Processes, AStoppedCoprocessorMakesSafeAndOperatesAgainOnceItGoesOn) {
    const auto hand = start("hand");
    ASSERT_TRUE(hand->has_said("waiting")) << hand->err();
    const auto coprocessor = start("coprocessor");
    ASSERT_TRUE(becomes("operating")) << hand->err();
    for (const int pause_ms : {500, 3000}) {
        coprocessor->signal(SIGSTOP);
        std::this_thread::sleep_for(milliseconds(pause_ms));
        EXPECT_TRUE(becomes("safe")) << hand->err();
        coprocessor->signal(SIGCONT);
        EXPECT_TRUE(becomes("operating")) << pause_ms << hand->err() << coprocessor->err();
    }
}

TEST_P(Processes, AStoppedHandOperatesAgainOnceItGoesOn) {
    const auto hand = start("hand");
    ASSERT_TRUE(hand->has_said("waiting")) << hand->err();
    const auto coprocessor = start("coprocessor");
    ASSERT_TRUE(becomes("operating")) << hand->err();
    for (const int pause_ms : {500, 3000}) {
        hand->signal(SIGSTOP);
        std::this_thread::sleep_for(milliseconds(pause_ms));
        hand->signal(SIGCONT);
        EXPECT_TRUE(becomes("operating")) << pause_ms << hand->err() << coprocessor->err();
    }
}

TEST_P(Processes, WhereTheUserReArmsASignalDoesAndANewSessionDoesNot) {
    const std::string waits = "waits for the user's acknowledgement";
    write_scene("rearm: BY_USER");
    const auto hand = start("hand");
    ASSERT_TRUE(hand->has_said("waiting")) << hand->err();
    auto coprocessor = start("coprocessor");
    ASSERT_TRUE(comes_to_say("reason", waits)) << hand->err();
    ASSERT_TRUE(operates_when_acknowledged(*hand)) << hand->err();
    coprocessor->signal(SIGKILL);
    ASSERT_TRUE(becomes("safe")) << hand->err();
    // There is nothing to acknowledge yet, and no signal is kept.
    hand->signal(SIGUSR1);
    coprocessor = start("coprocessor");
    ASSERT_TRUE(comes_to_say("reason", waits)) << hand->err() << coprocessor->err();
    std::this_thread::sleep_for(milliseconds(500));
    EXPECT_EQ(grip_state(), "safe");
    EXPECT_TRUE(operates_when_acknowledged(*hand)) << hand->err();
}

// Standard error is a pipe that is full and that nobody reads.
TEST_P(Processes, ATerminalThatTakesNothingStopsNothing) {
    ASSERT_EQ(::mkfifo(folder()("full").c_str(), 0600), 0);
    const int pipe = ::open(folder()("full").c_str(), O_RDWR | O_NONBLOCK);
    ASSERT_GE(pipe, 0);
    const std::string filling(4096, '.');
    while (::write(pipe, filling.data(), filling.size()) > 0) {
    }
    Process hand({"-c", "exec \"$0\" hand \"$1\" 2>\"$2\"", AFFERENT_PROGRAM, scene(), folder()("full")}, "",
                 "/bin/sh");
    auto coprocessor = start("coprocessor");
    EXPECT_TRUE(becomes("operating")) << coprocessor->err();
    coprocessor->signal(SIGKILL);
    EXPECT_TRUE(becomes("safe"));
    ::close(pipe);
}

INSTANTIATE_TEST_SUITE_P(Over, Processes, testing::Values("unix", "tcp", "tls", "udp"),
                         [](const auto& which) { return std::string(which.param); });

class IdleConnections : public Processes {};

TEST_P(IdleConnections, TakeLittleMemoryAndNoPlaceFromTheCoprocessor) {
    const auto hand = start("hand");
    ASSERT_TRUE(hand->has_said("waiting")) << hand->err();
    const Attacked attacked(*this);
    std::jthread attacker(
        [&](const std::stop_token& stop) { bench::hold_idle_connections(attacked.victim, 2000, stop); });
    std::this_thread::sleep_for(milliseconds(300));
    const auto coprocessor = start("coprocessor");
    EXPECT_TRUE(becomes("operating")) << hand->err() << coprocessor->err();
    expect_little_memory(*hand);
}

class Hellos : public Processes {};

// A hand under sanitizers answers a tenth as many beside its packets.
constexpr double hellos_per_s = long_runs ? 20'000 : 2'000;

// The hellos of strangers: without a cookie, and as far as a stranger gets who returns it.
TEST_P(Hellos, KeepNoCoprocessorOutAndNoHandFromItsSafeState) {
    const auto hand = start("hand");
    ASSERT_TRUE(hand->has_said("waiting")) << hand->err();
    const Attacked attacked(*this);
    for (const bool returned : {false, true}) {
        std::uint64_t count = 0;
        {
            std::jthread attacker([&](const std::stop_token& stop) {
                count = returned ? bench::return_cookies(attacked.victim, stop)
                                 : bench::send_hellos(attacked.victim, hellos_per_s, stop);
            });
            std::this_thread::sleep_for(milliseconds(300));
            auto coprocessor = start("coprocessor");
            // Where it gives up after its ten seconds, it is started again, as a service manager does.
            EXPECT_TRUE(comes_true([&] {
                if (coprocessor->err().find("no answer") != std::string::npos)
                    coprocessor = start("coprocessor");
                return status("grip_state") == "operating";
            })) << hand->err()
                << coprocessor->err();
            coprocessor->signal(SIGKILL);
            EXPECT_TRUE(becomes("safe")) << hand->err();
        }
        EXPECT_GT(count, 100U);
    }
    expect_little_memory(*hand);
}

INSTANTIATE_TEST_SUITE_P(Over, Hellos, testing::Values("udp_sealed"),
                         [](const auto& which) { return std::string(which.param); });

INSTANTIATE_TEST_SUITE_P(Over, IdleConnections, testing::Values("unix", "tcp", "tls"),
                         [](const auto& which) { return std::string(which.param); });

}  // namespace
}  // namespace afferent
