// afferent export, as a user would call it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

std::string refused(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "export");
    Process process(arguments);
    EXPECT_EQ(process.wait(), 1) << process.out();
    return process.err();
}

TEST(ExportProgram, WritesNeuronsThatAreEqualToTheEmulators) {
    const Folder folder;
    const std::string to = folder("chip");
    // Once more, over what is there.
    for (int i = 0; i < 2; ++i) {
        Process process({"export", examples + "chip.txtpb", "--c", to, "--json"});
        ASSERT_EQ(process.wait(), 0) << process.err();
        EXPECT_EQ(nlohmann::json::parse(process.out())["bytes_per_neuron"], 12);
    }
    EXPECT_EQ(std::system(("make -s -C '" + to + "' test >/dev/null").c_str()), 0);
    // A vector that is wrong in one bit is named.
    std::string vectors = read_file(folder / "chip/vectors.txt");
    const std::size_t at = vectors.find("\ns ");
    const std::size_t end = vectors.find('\n', at + 1);
    vectors[end - 1] = vectors[end - 1] == '0' ? '1' : '0';
    write_file(folder / "chip/vectors.txt", vectors);
    const std::string said = folder("said");
    EXPECT_NE(std::system(("make -s -C '" + to + "' test 2>'" + said + "'").c_str()), 0);
    EXPECT_NE(read_file(said).find("refractory is 0 and should be 1: bits 0x1 differ"), std::string::npos)
        << read_file(said);
}

TEST(ExportProgram, WritesACoreThatIsEqualToTheEmulators) {
    if (std::system("command -v iverilog >/dev/null") != 0)
        GTEST_SKIP() << "iverilog is not installed: scripts/install-dependencies.sh chip";
    const Folder folder;
    Process process({"export", examples + "chip.txtpb", "--verilog", folder("core"), "--json"});
    ASSERT_EQ(process.wait(), 0) << process.err();
    EXPECT_EQ(nlohmann::json::parse(process.out())["cycles_per_tick"], 9 * (8 + 3 * 16 + 20) + 1);
    const std::string said = folder("said");
    EXPECT_EQ(
        std::system(("make -s -C '" + folder("core") + "' icarus TICKS=300 >'" + said + "' 2>&1").c_str()),
        0);
    EXPECT_NE(read_file(said).find("9 neurons, 300 ticks"), std::string::npos) << read_file(said);
}

TEST(ExportProgram, SaysWhatItCannotDo) {
    const Folder folder;
    EXPECT_NE(refused({examples + "chip.txtpb"}).find("--c, --verilog or --vectors"), std::string::npos);
    EXPECT_NE(
        refused({examples + "chip.txtpb", "--c", folder("a"), "--verilog", folder("a")}).find("two folders"),
        std::string::npos);
    EXPECT_NE(refused({examples + "grasp.txtpb", "--c", folder("a")}).find("neuron { fixed_point {} }"),
              std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(folder / "a"));
    write_file(folder / "README.md", "mine");
    EXPECT_NE(refused({examples + "chip.txtpb", "--c", folder("")}).find("README.md is there"),
              std::string::npos);
    EXPECT_EQ(read_file(folder / "README.md"), "mine");
}

}  // namespace
}  // namespace afferent
