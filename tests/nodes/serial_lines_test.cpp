// Lines on pseudo-terminals: what comes over them, and that they are opened again when they have failed. In
// real time, with room.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/write.hpp>
#include <thread>

#include "afferent/hand/ability_hand_emulator.hpp"
#include "afferent/io/links/pseudo_terminal.hpp"
#include "afferent/nodes/ability_hand_line.hpp"
#include "afferent/nodes/chip_line.hpp"
#include "afferent/nodes/reopened_line.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

template <class Condition>
bool within_a_minute(Condition condition) {
    for (const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(1); !condition();) {
        if (std::chrono::steady_clock::now() > limit) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
}

// A terminal that can be taken away and be there again, under one name.
class Terminal {
  public:
    Terminal() { plug_in(); }
    void plug_in() {
        terminal_.emplace(value_or_throw(NamedTerminal::open(io_, path())));
        ours_.emplace(terminal_->take_ours());
    }
    void pull_out() {
        ours_.reset();
        terminal_.reset();
    }
    void write(const std::string& text) { boost::asio::write(*ours_, boost::asio::buffer(text)); }
    void write(std::span<const std::byte> bytes) {
        boost::asio::write(*ours_, boost::asio::buffer(bytes.data(), bytes.size()));
    }
    // What has come, without waiting.
    std::vector<std::byte> read() {
        std::vector<std::byte> bytes(1000);
        ours_->non_blocking(true);
        boost::system::error_code nothing;
        bytes.resize(ours_->read_some(boost::asio::buffer(bytes), nothing));
        return bytes;
    }
    std::string path() const { return folder_("tty"); }

  private:
    Folder folder_;
    boost::asio::io_context io_;
    std::optional<NamedTerminal> terminal_;
    std::optional<boost::asio::posix::stream_descriptor> ours_;
};

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

TEST(ReopenedLine, IsOpenedAgainAndSaysSo) {
    Terminal terminal;
    ReopenedLine line(terminal.path(), 115'200, "box");
    ASSERT_TRUE(line.open());
    EXPECT_TRUE(line.write(bytes_of("a")));
    std::array<std::byte, 8> bytes{};
    EXPECT_EQ(line.read(bytes, 1ms), std::optional<std::size_t>(0)) << "nothing has come";
    terminal.write("xyz");
    EXPECT_EQ(line.read(bytes, 900ms), std::optional<std::size_t>(3));
    EXPECT_FALSE(line.next_note());

    terminal.pull_out();
    EXPECT_TRUE(within_a_minute([&] { return !line.read(bytes, 1ms); }));
    EXPECT_FALSE(line.is_open());
    EXPECT_EQ(line.next_note(), "the line to the box has failed; it is opened again as soon as it is there");
    for (int i = 0; i < 30; ++i) EXPECT_FALSE(line.try_again()) << "it is not there";
    EXPECT_FALSE(line.next_note());
    terminal.plug_in();
    EXPECT_TRUE(within_a_minute([&] { return line.try_again(); }));
    EXPECT_TRUE(line.is_open());
    EXPECT_EQ(line.next_note(), "the line to the box is there again");
}

TEST(ReopenedLine, NoticesByWritingThatItHasFailed) {
    Terminal terminal;
    ReopenedLine line(terminal.path(), 115'200, "box");
    ASSERT_TRUE(line.open());
    terminal.pull_out();
    ASSERT_TRUE(within_a_minute([&] { return !line.write(bytes_of("a")); }));
    EXPECT_FALSE(line.is_open());
    EXPECT_EQ(line.next_note(), "the line to the box has failed; it is opened again as soon as it is there");
}

TEST(ReopenedLine, KeepsNoMoreNotesThanItHasRoomFor) {
    ReopenedLine line("nowhere", 115'200, "box");
    int kept = 0;
    while (kept < 1000 && line.tell(std::to_string(kept))) ++kept;
    EXPECT_EQ(kept, 64);
    for (int i = 0; i < kept; ++i) EXPECT_EQ(line.next_note(), std::to_string(i));
    EXPECT_FALSE(line.next_note());
}

Plan plan_of(const std::string& source, const std::string& hand, const std::string& patch) {
    return make_plan(Scene::from_text("duration_s: 1 source { " + source + " } link { tcp {} } hand { " +
                                      hand + " } " + patch));
}

Plan plan_of_a_chip(const std::string& device) {
    return plan_of("chip { device: '" + device + "' }", "",
                   "patch { name: 'a' elements: 1 share: [1] neuron { fixed_point {} } }");
}

TEST(ChipLine, HandsOverWhatComesWithItsTime) {
    Terminal terminal;
    const Plan plan = plan_of_a_chip(terminal.path());
    const auto line = value_or_throw(open_chip_line(plan));
    EXPECT_EQ(line->next(), nullptr);
    const MonotonicTime before = std::chrono::steady_clock::now();
    std::string come;
    terminal.write("one");
    ASSERT_TRUE(within_a_minute([&] {
        const ChipBytes* const bytes = line->next();
        if (!bytes) return false;
        EXPECT_GE(bytes->at, before);
        EXPECT_LE(bytes->at, std::chrono::steady_clock::now());
        for (const std::byte byte : bytes->bytes) come += static_cast<char>(byte);
        return come.size() == 3;
    }));
    EXPECT_EQ(come, "one");
    EXPECT_EQ(line->next(), nullptr) << "bytes are handed over once";

    terminal.pull_out();
    std::optional<std::string> note;
    ASSERT_TRUE(within_a_minute([&] { return (note = line->next_note()).has_value(); }));
    EXPECT_NE(note->find("the line to the chip has failed"), std::string::npos) << *note;
    terminal.plug_in();
    ASSERT_TRUE(within_a_minute([&] { return (note = line->next_note()).has_value(); }));
    EXPECT_NE(note->find("is there again"), std::string::npos) << *note;
    terminal.write("two");
    EXPECT_TRUE(within_a_minute([&] { return line->next() != nullptr; }));
}

TEST(ChipLine, NamesTheFieldOfADeviceThatIsNotThere) {
    const Plan plan = plan_of_a_chip("/nowhere/tty");
    const auto line = open_chip_line(plan);
    ASSERT_FALSE(line);
    EXPECT_NE(line.error().text.find("source.chip.device: /nowhere/tty"), std::string::npos)
        << line.error().text;
}

Plan plan_of_a_hand(const std::string& port) {
    std::string patches;
    for (const char* const finger : {"index", "middle", "ring", "little", "thumb"})
        patches += std::string(" patch { name: '") + finger +
                   "' elements: 6 share: [0.03, 0.03, 0.03, 0.03, 0.03, 0.03] }";
    return plan_of("hand_sensors {}", "ability_hand { port: '" + port + "' }", patches);
}

TEST(AbilityHandLine, HandsOverTheForcesOfAllSensorsInTheirOrder) {
    Terminal terminal;
    AbilityHandEmulator emulator{{}};
    for (std::size_t i = 0; i < ability_hand::sensors; ++i)
        emulator.faults().stuck_counts[i] = static_cast<std::uint16_t>(300 + 100 * i);
    const auto hand = value_or_throw(open_ability_hand(plan_of_a_hand(terminal.path())));
    const MonotonicTime began = std::chrono::steady_clock::now();
    hand->start([] {});
    const HandScan* scan = nullptr;
    ASSERT_TRUE(within_a_minute([&] {
        const TimePoint now = scene_start + (std::chrono::steady_clock::now() - began);
        emulator.receive(now, terminal.read());
        emulator.advance(now);
        std::vector<std::byte> reply;
        emulator.send(now, reply);
        terminal.write(reply);
        return (scan = hand->next_scan()) != nullptr;
    }));
    EXPECT_GE(scan->at, began);
    ASSERT_EQ(scan->forces_n.size(), ability_hand::sensors);
    EXPECT_GT(scan->forces_n.front(), 0);
    EXPECT_TRUE(std::ranges::is_sorted(scan->forces_n, std::less_equal<>()))
        << "each feels more than the last";
}

TEST(AbilityHandLine, CountsALineThatIsLost) {
    Terminal terminal;
    const Plan plan = plan_of_a_hand(terminal.path());
    const auto hand = value_or_throw(open_ability_hand(plan));
    std::atomic<int> arrived{0};
    hand->start([&] { ++arrived; });
    terminal.pull_out();
    std::optional<std::string> note;
    ASSERT_TRUE(within_a_minute([&] { return (note = hand->next_note()).has_value(); }));
    EXPECT_NE(note->find("the line to the hand has failed"), std::string::npos) << *note;
    EXPECT_TRUE(within_a_minute([&] { return hand->readings().lost_lines == 1; }));
    EXPECT_GT(arrived, 0) << "who sleeps is woken for the note";
    terminal.plug_in();
    ASSERT_TRUE(within_a_minute([&] { return (note = hand->next_note()).has_value(); }));
    EXPECT_NE(note->find("is there again"), std::string::npos) << *note;
}

}  // namespace
}  // namespace afferent
