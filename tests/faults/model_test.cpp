// Random sequences of faults, a million in all, and after each what must hold of a hand.
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/faults/faulty_nodes.hpp"
#include "tests/faults/hostile_messages.hpp"
#include "tests/long_runs.hpp"

namespace afferent {
namespace {

// A part of the same sequences, or all of them.
constexpr std::uint64_t faults_in_all = long_runs ? 1'000'000 : 50'000;
constexpr std::uint64_t faults_in_a_run = 5'000;

struct Case {
    const char* name;
    NetworkKind kind;
    std::string (*scene)();
};

std::string reaching_scene() { return reaching(); }

class Model {
  public:
    Model(const Case& which, std::uint64_t seed) : random_(seed), nodes_(which.scene(), which.kind) {
        nodes_.network.fate = [this](const auto&, FaultyNetwork::Side) { return fate(); };
    }

    // Returns how many faults there were.
    std::uint64_t run() {
        nodes_.run_for(500ms);
        while (faults_ < faults_in_a_run && nodes_.property().violations().empty()) {
            ++faults_;
            do_something();
            nodes_.run_for(milliseconds(chance(0.05) ? 300 : 12));
        }
        return faults_;
    }

    // When the faults are over the hand works again, with the next coprocessor at the latest.
    void recover() {
        weather_ = {};
        nodes_.stop(FaultyNetwork::hand, false);
        nodes_.stop(FaultyNetwork::coprocessor, false);
        nodes_.network.cut(false);
        nodes_.drift(0);
        nodes_.silence_sensors(false);
        stranger_.reset();
        // Messages that are still under way are subject to the faults before.
        nodes_.kill_coprocessor();
        nodes_.run_for(1s);
        nodes_.start_coprocessor();
        nodes_.run_for(3s);
    }

    FaultyNodes& nodes() { return nodes_; }

  private:
    // What happens to messages at the moment.
    struct Weather {
        double loss = 0;
        double duplicates = 0;
        double delays = 0;
        Duration shortest{};
        std::uint64_t more_ms = 25;
    };

    bool chance(double probability) { return std::uniform_real_distribution<>()(random_) < probability; }
    std::uint64_t below(std::uint64_t limit) { return random_() % limit; }
    Duration milliseconds(std::uint64_t most) { return Duration(below(most * 1'000'000)); }

    FaultyNetwork::Fate fate() {
        FaultyNetwork::Fate fate;
        if (chance(weather_.loss)) fate.copies = 0;
        if (chance(weather_.duplicates)) fate.copies += 1;
        if (chance(weather_.delays)) fate.delay = weather_.shortest + milliseconds(weather_.more_ms);
        if (fate.copies != 1 || fate.delay > Duration::zero()) ++faults_;
        return fate;
    }

    void change_weather() {
        weather_ = {};
        if (chance(0.3)) return;
        const double bad = chance(0.2) ? 0.9 : 0.2;
        if (chance(0.5)) weather_.loss = bad;
        if (chance(0.5)) weather_.duplicates = bad;
        if (chance(0.5)) weather_.delays = bad;
        if (chance(0.5)) return;
        // Above the age at which packets are stale.
        weather_.shortest = 150ms;
        weather_.more_ms = 250;
    }

    void do_something() {
        switch (below(16)) {
            case 0:
            case 1:
            case 2:
                return change_weather();
            case 3:
                return nodes_.stop(FaultyNetwork::hand, chance(0.5));
            case 4:
                return nodes_.stop(FaultyNetwork::coprocessor, chance(0.5));
            case 5:
                return nodes_.network.cut(chance(0.5));
            case 6:
                return chance(0.5) ? nodes_.kill_coprocessor() : nodes_.start_coprocessor();
            case 7:
                return chance(0.2) ? nodes_.start_hand() : void();
            case 8:
                return nodes_.drift(chance(0.5) ? 0 : static_cast<double>(below(801)) - 400);
            case 9:
                return nodes_.silence_sensors(chance(0.5));
            case 10:
                if (nodes_.coprocessor() && chance(0.3)) nodes_.coprocessor()->interrupt();
                return;
            case 11:
                stranger_ =
                    chance(0.7) ? std::make_unique<Stranger>(nodes_.network, stranger_says()) : nullptr;
                return;
            default:
                return nodes_.network.inject(hostile_message(random_, nodes_.plan(), hello_));
        }
    }

    std::vector<proto::Envelope> stranger_says() {
        std::vector<proto::Envelope> messages;
        if (chance(0.5)) messages.push_back(chance(0.7) ? hello_ : other_hello_);
        for (std::uint64_t i = below(4); i > 0; --i)
            if (auto message = hostile_message(random_, nodes_.plan(), hello_))
                messages.push_back(std::move(*message));
        return messages;
    }

    std::mt19937_64 random_;
    Weather weather_;
    std::uint64_t faults_ = 0;
    FaultyNodes nodes_;
    // Made once: a fingerprint takes longer than all else.
    const proto::Envelope hello_ = hello_of(nodes_.plan());
    const proto::Envelope other_hello_ = hello_of(nodes_.plan(), false);
    std::unique_ptr<Stranger> stranger_;
};

class AMillionFaults : public testing::TestWithParam<Case> {};

TEST_P(AMillionFaults, LeaveTheHandSafe) {
    constexpr std::uint64_t cases = 6;
    std::uint64_t faults = 0;
    for (std::uint64_t seed = 1; faults < faults_in_all / cases; ++seed) {
        Model model(GetParam(), seed);
        faults += model.run();
        if (model.nodes().property().violations().empty()) model.recover();
        const auto& violations = model.nodes().property().violations();
        ASSERT_TRUE(violations.empty()) << "seed " << seed << ": " << violations[0];
        ASSERT_EQ(model.nodes().hand()->report().state, GripState::operating)
            << "seed " << seed << ": it does not recover: " << model.nodes().hand()->report().reason;
    }
}

INSTANTIATE_TEST_SUITE_P(All, AMillionFaults,
                         testing::Values(Case{"ReachingOverAStream", NetworkKind::stream, reaching_scene},
                                         Case{"HoldingOverAStream", NetworkKind::stream, holding},
                                         Case{"FedOverAStream", NetworkKind::stream, fed},
                                         Case{"ReachingOverDatagrams", NetworkKind::datagrams,
                                              reaching_scene},
                                         Case{"HoldingOverDatagrams", NetworkKind::datagrams, holding},
                                         Case{"FedOverDatagrams", NetworkKind::datagrams, fed}),
                         [](const auto& which) { return std::string(which.param.name); });

}  // namespace
}  // namespace afferent
