// The exported firmware on boards that QEMU emulates, in real time, as the coprocessor of a hand.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

// The sanitizers make the emulator too slow for a chip in real time on ticks of 0.1 ms.
#ifdef __SANITIZE_ADDRESS__
constexpr const char* tick_us = "1000";
#else
constexpr const char* tick_us = "100";
#endif

std::string text_of(const std::string& example, int duration_s, const std::string& source,
                    const std::string& link) {
    std::string text = read_file(examples + example);
    for (const auto& [from, to] : std::initializer_list<std::pair<std::string, std::string>>{
             {"\nsource {", "\nsource { " + source + " } #"},
             {"\nlink {", "\nlink { " + link + " } #"},
             {"fixed_point { tick_us: 100", std::string("fixed_point { tick_us: ") + tick_us},
             {"\nduration_s:", "\nduration_s: " + std::to_string(duration_s) + " #"}}) {
        const std::size_t at = text.find(from);
        if (at == std::string::npos) throw std::runtime_error(example + " has no " + from);
        text.replace(at, from.size(), to);
    }
    return text;
}

class ChipTwin : public testing::TestWithParam<const char*> {
  protected:
    // What both ends say of a grasp.
    nlohmann::json chip_;
    nlohmann::json hand_;

    void grasp();
    std::pair<int, int> ends_;
    std::string said_;
    // A frame was lost, or the board stood still for so long that the hand gave the session up.
    bool was_disturbed() const {
        return ends_ != std::pair(0, 0) || chip_["gaps"] != 0 || chip_["refused_frames"] != 0 ||
               chip_["checksum_failures"] != 0;
    }
};

void ChipTwin::grasp() {
    const Folder folder;
    const std::string link = "unix_socket { path: \"s\" } " + patient;
    write_file(folder / "scene.txtpb", text_of("chip.txtpb", 10, "simulated_hand {}", link));
    // A touch is compared from its beginning: nothing is touched until both programs are there, however slow
    // they are.
    const auto begin = std::chrono::steady_clock::now();
    Process planned({"plan", folder("scene.txtpb")});
    ASSERT_EQ(planned.wait(), 0) << planned.err();
    const auto start = std::chrono::ceil<std::chrono::seconds>(std::chrono::steady_clock::now() - begin);
    const int untouched_s = 3 + 3 * static_cast<int>(start.count());
    // The grasp touches after two seconds, and the twin begins some before the hand.
    write_file(folder / "live.txtpb", text_of("chip_on_line.txtpb", untouched_s + 3,
                                              "chip { device: \"chip/chip.tty\" compare: true }", link));
    Process exported({"export", folder("scene.txtpb"), "--c", folder("chip")});
    ASSERT_EQ(exported.wait(), 0) << exported.err();
    const std::string make = "make -s -C '" + folder("chip") + "' BOARD=" + GetParam() +
                             " CFLAGS='-std=c99 -O2 -DUNTOUCHED_S=" + std::to_string(untouched_s) + "'";
    ASSERT_EQ(std::system((make + " twin." + GetParam()).c_str()), 0);
    ASSERT_EQ(std::system(("timeout 120 " + make + " twin >'" + folder("said") + "' 2>&1 &").c_str()), 0);
    ASSERT_TRUE(comes_true([&] { return std::filesystem::exists(folder / "chip/chip.tty"); }));

    Process coprocessor({"coprocessor", folder("live.txtpb"), "--json"});
    // QEMU looks once a second whether somebody listens.
    std::this_thread::sleep_for(std::chrono::milliseconds(1300));
    Process hand({"hand", folder("live.txtpb"), "--json"});
    ends_ = {coprocessor.wait(), hand.wait()};
    said_ = coprocessor.err() + hand.err();
    if (ends_ != std::pair(0, 0)) return;
    chip_ = nlohmann::json::parse(coprocessor.out())["chip"];
    hand_ = nlohmann::json::parse(hand.out());
}

// On a busy machine the board and the programs lose time against each other, which the coprocessor then says;
// the events are the emulator's all the same. Where QEMU loses bytes or stands still, the grasp is repeated.
TEST_P(ChipTwin, IsTheCoprocessorOfAHandAndEqualToTheEmulator) {
    for (const char* const program :
         {"arm-none-eabi-gcc", "riscv64-unknown-elf-gcc", "qemu-system-arm", "qemu-system-riscv32"})
        if (std::system(("command -v " + std::string(program) + " >/dev/null").c_str()) != 0)
            GTEST_SKIP() << program << " is not installed: scripts/install-dependencies.sh chip";
    for (int attempt = 0; attempt < 3 && (attempt == 0 || was_disturbed()); ++attempt) {
        ASSERT_NO_FATAL_FAILURE(grasp());
    }
    ASSERT_EQ(ends_, std::pair(0, 0)) << said_;
    EXPECT_GE(chip_["beginnings"], 1) << chip_;
    EXPECT_EQ(chip_["comparison"]["chip_alone"], 0) << chip_;
    EXPECT_EQ(chip_["comparison"]["emulator_alone"], 0) << chip_;
    EXPECT_GT(chip_["comparison"]["equal"], 100) << chip_;
    EXPECT_GT(hand_["events"], 100) << hand_;
    EXPECT_EQ(hand_["safe_states"], 0) << hand_;
}

INSTANTIATE_TEST_SUITE_P(Boards, ChipTwin, testing::Values("cortex-m3", "riscv"), [](const auto& each) {
    return each.param == std::string("riscv") ? "RiscV" : "CortexM3";
});

}  // namespace
}  // namespace afferent
