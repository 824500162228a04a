// What each example gives is the same from one version to the next: example_outputs.txt holds the hash of
// every file. Where a result is meant to change, the changelog's Numbers says so, and the lines that this
// test prints replace the old ones.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "afferent/io/files/recording.hpp"
#include "tests/apps/process.hpp"

namespace afferent {
namespace {

std::string hash(const std::string& bytes) {
    std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
    for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(hash));
    return text.data();
}

// All entries but the head, which has the scene's text, the hello's fingerprints of that and its nonce, and
// the index, which has their places in the file.
std::string recorded_entries(const std::filesystem::path& file) {
    auto reader = RecordingReader::open(file);
    EXPECT_TRUE(reader) << reader.error().text;
    std::string bytes;
    for (proto::Entry entry; reader;) {
        const auto next = reader.value().next(entry);
        EXPECT_TRUE(next);
        if (!next || !next.value()) break;
        if (entry.has_head() || entry.has_index()) continue;
        if (entry.link().has_hello()) {
            entry.mutable_link()->mutable_hello()->clear_scene_fingerprint();
            entry.mutable_link()->mutable_hello()->clear_part();
            entry.mutable_link()->mutable_hello()->clear_nonce();
        }
        bytes += entry.SerializeAsString();
    }
    return bytes;
}

std::map<std::string, std::string> expected_hashes() {
    std::map<std::string, std::string> hashes;
    std::ifstream in(AFFERENT_SOURCE_DIR "/tests/apps/example_outputs.txt");
    for (std::string name, value; in >> name >> value;) hashes[name] = value;
    return hashes;
}

class ExampleOutputs : public testing::TestWithParam<const char*> {};

TEST_P(ExampleOutputs, AreThoseOfTheVersionBefore) {
    const std::string example = GetParam();
    const Folder folder;
    Process run({"run", AFFERENT_SOURCE_DIR "/examples/" + example + ".txtpb", "--out", folder("out"),
                 "--record", folder("out.afferent")});
    ASSERT_EQ(run.wait(), 0) << run.err();
    const auto expected = expected_hashes();
    const auto compare = [&](const std::string& name, const std::string& bytes) {
        const auto found = expected.find(example + "/" + name);
        EXPECT_EQ(found == expected.end() ? "none" : found->second, hash(bytes))
            << example << "/" << name << ' ' << hash(bytes);
    };
    for (const char* const name : {"events.csv", "force.csv", "emg.csv"})
        if (std::filesystem::exists(folder / "out" / name)) compare(name, read_file(folder / "out" / name));
    for (const auto& [name, value] : expected)
        if (name.starts_with(example + "/") && name.ends_with(".csv")) {
            EXPECT_TRUE(std::filesystem::exists(folder / "out" / name.substr(example.size() + 1))) << name;
        }
    auto summary = nlohmann::ordered_json::parse(read_file(folder / "out" / "summary.json"));
    summary.erase("run_time_s");
    compare("summary.json", summary.dump());
    compare("recording", recorded_entries(folder / "out.afferent"));
}

INSTANTIATE_TEST_SUITE_P(Scenes, ExampleOutputs,
                         testing::Values("grasp", "paper", "recorded", "lossy", "bus", "two_channels",
                                         "fingertip"),
                         [](const auto& example) { return std::string(example.param); });

}  // namespace
}  // namespace afferent
