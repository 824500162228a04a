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

// An implementation of somebody's own: the vectors' records themselves, and then with a fault each.
TEST(ExportProgram, ComparesAnImplementationOfSomebodysOwn) {
    const Folder folder;
    Process process({"export", examples + "chip.txtpb", "--set", "neuron.fixed_point.tick_us=1000", "--set",
                     "link.tick_us=1000", "--vectors", folder("v")});
    ASSERT_EQ(process.wait(), 0) << process.err();
    const auto said = [&] {
        (void)std::system(("make -s -C '" + folder("v") + "' test >'" + folder("said") + "' 2>&1").c_str());
        return read_file(folder / "said");
    };
    EXPECT_NE(said().find("yours.txt is missing"), std::string::npos) << said();
    const std::string vectors = read_file(folder / "v/vectors.txt");
    const auto compared = [&](const std::string& yours) {
        write_file(folder / "v/yours.txt", yours);
        return said();
    };
    EXPECT_NE(compared(vectors).find(" states, "), std::string::npos) << said();
    EXPECT_NE(said().find(": equal"), std::string::npos);
    const auto line_at = [&](const char* kind) {
        const std::size_t at = vectors.find(kind, vectors.size() / 2) + 1;
        return std::pair(at, vectors.find('\n', at));
    };
    const auto [event, event_end] = line_at("\ne ");
    const std::string tick = vectors.substr(event + 2, vectors.find(' ', event + 2) - event - 2);
    EXPECT_NE(compared(vectors.substr(0, event) + vectors.substr(event_end + 1)).find("tick " + tick),
              std::string::npos)
        << said();
    EXPECT_NE(said().find("event is missing"), std::string::npos) << said();
    const std::string twice = vectors.substr(event, event_end + 1 - event);
    EXPECT_NE(compared(vectors.substr(0, event) + twice + vectors.substr(event)).find("tick "),
              std::string::npos);
    std::string other = vectors;
    const std::size_t bit = line_at("\ns ").second - 1;
    other[bit] = other[bit] == '0' ? '1' : '0';
    EXPECT_NE(compared(other).find("refractory differs in the bits 0x1"), std::string::npos) << said();
    other = vectors;
    const std::size_t digit = line_at("\nf ").second - 3;
    other[digit] = other[digit] == '0' ? '1' : '0';
    EXPECT_NE(compared(other).find("bytes on the line differ"), std::string::npos) << said();
    EXPECT_NE(compared(vectors.substr(0, event)).find("yours:    nothing"), std::string::npos) << said();
    EXPECT_NE(compared(vectors + "e 999999999 0\n").find("behind the end"), std::string::npos) << said();
}

TEST(ExportProgram, SaysWhatItCannotDo) {
    const Folder folder;
    EXPECT_NE(refused({examples + "chip.txtpb"}).find("--c, --verilog or --vectors"), std::string::npos);
    EXPECT_NE(refused({examples + "chip.txtpb", "--c", folder("a"), "--verilog", folder("a")})
                  .find("a folder for each"),
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
