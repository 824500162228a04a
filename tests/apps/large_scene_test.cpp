// A scene of more afferents than 16 bits count, which all fire at once, over every link.
#include <nlohmann/json.hpp>

#include "tests/apps/process.hpp"

namespace afferent {
namespace {

TEST(LargeScene, RunsOverEveryLink) {
    const Folder folder;
    for (const char* link :
         {"in_process {}", "tcp {}", "udp {}", "unix_socket {}", "file { path: 'f.afferent' }",
          "tcp {} encoding: FIXED_WIDTH packet_events: 50000"}) {
        write_file(folder / "s.txtpb", R"(duration_s: 0.006 record { picture: false }
            every_patch { elements: 24000 encoder { sustained { gain_mv_per_n: 1 bias_mv: 40 } } }
            source { profile { point { force_n: 1 } } }
            link { )" + std::string(link) + " }");
        Process run({"run", folder("s.txtpb"), "--json"});
        EXPECT_EQ(run.wait(), 0) << link << ": " << run.err();
        const auto summary = nlohmann::json::parse(run.out(), nullptr, false);
        ASSERT_FALSE(summary.is_discarded()) << link << ": " << run.err();
        EXPECT_EQ(summary.at("events"), 72'000) << link;
    }
}

}  // namespace
}  // namespace afferent
