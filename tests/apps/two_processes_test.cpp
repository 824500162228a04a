#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>
#include <span>
#include <thread>

#include "afferent/io/links/link.hpp"
#include "bench/serial_line.hpp"
#include "tests/apps/process.hpp"
#include "tests/long_runs.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using Json = nlohmann::json;

constexpr const char* short_grasp = R"(
    duration_s: 1.5
    hand { user { close_at_s: 0.1 close_for_s: 0.6 hold_for_s: 0.4 open_for_s: 0.2 effort: 0.7 }
           object { distance_mm: 5 stiffness_n_per_mm: 1 } }
)";
// The hand closes for so long that it has grasped, however late it may begin.
constexpr const char* long_grasp = R"(
    duration_s: 3
    hand { user { close_at_s: 0.1 close_for_s: 2.3 hold_for_s: 0.3 open_for_s: 0.2 effort: 0.7 }
           object { distance_mm: 5 stiffness_n_per_mm: 1 } }
)";

std::string unix_link(const std::string& more = "") {
    return "link { unix_socket { path: \"hand.sock\" } " + more + " }";
}

// A port that was free a moment ago: not one of those that the system gives out by itself.
std::string tcp_link() {
    return "link { tcp { port: " + std::to_string(20'000 + ::getpid() % 10'000) + " } }";
}

// The scene's folder "keys".
void make_keys(const Folder& folder) {
    Process keys({"keys", folder("keys")});
    ASSERT_EQ(keys.wait(), 0) << keys.err();
}

std::uint16_t free_port() { return static_cast<std::uint16_t>(20'000 + ::getpid() % 10'000); }

std::string udp_link(const std::string& more = "", std::uint16_t port = free_port()) {
    return "link { udp { port: " + std::to_string(port) + " } " + more + " }";
}

const std::string sealed = "keys: \"keys\"";

// All but the true force, which a hand without the samples does not know.
std::string without_truth(const std::string& force_csv) {
    return std::regex_replace(force_csv, std::regex("(\n[^,]*),[^,]*,"), "$1,");
}

// More bytes than that cross the link.
void expect_lockstep_equals_run(const std::string& scene_text, const std::string& more_files = "",
                                std::uint64_t bytes = 0) {
    const Folder folder;
    if (!more_files.empty()) std::filesystem::copy(more_files, folder / "data");
    const auto scene = write_file(folder / "s.txtpb", scene_text).string();
    Process run({"run", scene, "--out", folder("run"), "--json"});
    ASSERT_EQ(run.wait(), 0) << run.err();
    Process hand({"hand", scene, "--lockstep", "--out", folder("hand"), "--json"});
    ASSERT_TRUE(hand.has_said("waiting")) << hand.err();
    Process coprocessor({"coprocessor", scene, "--lockstep", "--out", folder("coprocessor"), "--json"});
    EXPECT_EQ(coprocessor.wait(), 0) << coprocessor.err();
    EXPECT_EQ(hand.wait(), 0) << hand.err();

    EXPECT_GT(read_file(folder / "run/events.csv").size(), 500U);
    EXPECT_GT(read_file(folder / "run/force.csv").size(), 10'000U);
    EXPECT_EQ(read_file(folder / "run/events.csv"), read_file(folder / "coprocessor/events.csv"));
    EXPECT_EQ(without_truth(read_file(folder / "run/force.csv")),
              without_truth(read_file(folder / "hand/force.csv")));
    const Json at_once = Json::parse(run.out());
    const Json sent = Json::parse(coprocessor.out());
    const Json received = Json::parse(hand.out());
    for (const char* count : {"events", "packets", "link_bytes", "raw_sample_bytes", "samples"})
        EXPECT_EQ(sent.at(count), at_once.at(count)) << count;
    EXPECT_GT(sent.at("link_bytes").get<std::uint64_t>(), bytes);
    EXPECT_EQ(received.at("events"), sent.at("events"));
    EXPECT_EQ(received.at("packets"), sent.at("packets"));
    EXPECT_EQ(received.at("gaps"), 0);
}

TEST(TwoProcesses, InLockstepOverAUnixSocketAreOne) { expect_lockstep_equals_run(short_grasp + unix_link()); }

TEST(TwoProcesses, InLockstepOverTcpAreOne) { expect_lockstep_equals_run(short_grasp + tcp_link()); }

TEST(TwoProcesses, InLockstepWithPredictedSpikesAreOne) {
    expect_lockstep_equals_run(short_grasp + unix_link("encoding: PREDICTED timing_tolerance_us: 500"));
}

TEST(TwoProcesses, InLockstepWithTheSamplesAtTheCoprocessorAreOne) {
    expect_lockstep_equals_run(
        "duration_s: 3 source { table { path: 'data/grip.csv' } } "
        "hand { emg_table { path: 'data/emg.csv' } }" +
            unix_link(),
        examples + "data");
}

TEST(TwoProcesses, InLockstepWithATableAtTheHandAreOne) {
    expect_lockstep_equals_run(
        "duration_s: 3 source { link { table { path: 'data/grip.csv' } } }" + unix_link(), examples + "data");
}

// Far more is sent at once than a queue holds, each way: nothing is dropped, and neither end gives up.
TEST(TwoProcesses, InLockstepLoseNothingAtScale) {
    // Each element feels so small a part of the grip: a few millinewtons at most.
    const std::string elements = long_runs ? "20000" : "5000";
    const std::string skin =
        "patch { name: 'skin' elements: " + elements + " sensor { full_scale_n: 0.01 } } ";
    expect_lockstep_equals_run("duration_s: 0.5 source { profile { point { time_s: 0 force_n: 20 } } }" +
                                   skin + unix_link("encoding: FIXED_WIDTH"),
                               "", 10 * LinkOptions{}.queue_bytes);
    expect_lockstep_equals_run(short_grasp + skin + tcp_link());
}

struct Summaries {
    Json sent;
    Json received;
};

// Both end well, and every event has arrived or is known to be lost.
Summaries expect_all_accounted_for(Process& hand, Process& coprocessor) {
    EXPECT_EQ(coprocessor.wait(), 0) << coprocessor.err();
    EXPECT_EQ(hand.wait(), 0) << hand.err();
    Summaries told{Json::parse(coprocessor.out()), Json::parse(hand.out())};
    EXPECT_EQ(told.received.at("events").get<int>() + told.received.at("lost_events").get<int>(),
              told.sent.at("events"));
    return told;
}

TEST(TwoProcesses, InRealTimeAccountForEveryEvent) {
    for (const std::string& link :
         {unix_link(patient), udp_link(patient), udp_link(sealed + " " + patient)}) {
        const Folder folder;
        make_keys(folder);
        const auto scene = write_file(folder / "s.txtpb", long_grasp + link).string();
        Process hand({"hand", scene, "--json"});
        Process coprocessor({"coprocessor", scene, "--json"});
        const auto [sent, received] = expect_all_accounted_for(hand, coprocessor);
        EXPECT_GT(sent.at("events"), 50) << link;
        EXPECT_EQ(received.at("sessions"), 1) << link;
        EXPECT_EQ(received.at("safe_states"), 0) << link;
    }
}

TEST(TwoProcesses, WithATableAtTheCoprocessorMeetOverUdp) {
    const Folder folder;
    std::filesystem::copy(examples + "data", folder / "data");
    const auto scene =
        write_file(folder / "s.txtpb",
                   "duration_s: 2 source { table { path: 'data/grip.csv' } }" + udp_link(patient))
            .string();
    Process hand({"hand", scene, "--json"});
    Process coprocessor({"coprocessor", scene, "--json"});
    const auto [sent, received] = expect_all_accounted_for(hand, coprocessor);
    EXPECT_EQ(received.at("complete"), true);
}

// Between a coprocessor and a hand on this machine, on a thread of its own. Loses what it is told to.
class LossyWay {
  public:
    using Loses = std::function<bool(std::span<const char> datagram)>;

    LossyWay(std::uint16_t hand, Loses loses)
        : loses_(std::move(loses)),
          hand_(loopback, hand),
          front_(io_, {loopback, 0}),
          back_(io_, {loopback, 0}) {
        forward(front_, coprocessor_, back_, hand_);
        forward(back_, from_hand_, front_, coprocessor_);
        thread_ = std::thread([this] { io_.run(); });
    }
    ~LossyWay() {
        io_.stop();
        thread_.join();
    }

    std::uint16_t port() const { return front_.local_endpoint().port(); }

  private:
    using udp = asio::ip::udp;
    static inline const auto loopback = asio::ip::address_v4::loopback();

    void forward(udp::socket& from, udp::endpoint& sender, udp::socket& to, const udp::endpoint& receiver) {
        from.async_receive_from(
            asio::buffer(bytes_.at(&from == &front_ ? 0 : 1)), sender,
            [&, this](const boost::system::error_code& error, std::size_t count) {
                const std::span datagram(bytes_.at(&from == &front_ ? 0 : 1).data(), count);
                boost::system::error_code ignored;
                if (!error && !loses_(datagram))
                    to.send_to(asio::buffer(datagram.data(), datagram.size()), receiver, 0, ignored);
                forward(from, sender, to, receiver);
            });
    }

    asio::io_context io_;
    Loses loses_;
    udp::endpoint hand_;
    udp::endpoint coprocessor_;
    udp::endpoint from_hand_;
    udp::socket front_;
    udp::socket back_;
    std::array<std::array<char, 4096>, 2> bytes_{};
    std::thread thread_;
};

// The two ends of a scene that differ only in their link.
std::pair<std::string, std::string> scenes(const Folder& folder, const std::string& rest,
                                           const std::string& hand_link,
                                           const std::string& coprocessor_link) {
    return {write_file(folder / "hand.txtpb", rest + hand_link).string(),
            write_file(folder / "coprocessor.txtpb", rest + coprocessor_link).string()};
}

// The scene begins and ends without one datagram in four and without any clock.
TEST(TwoProcesses, NeedNoMessageInParticular) {
    for (const bool samples_at_hand : {true, false}) {
        const Folder folder;
        std::filesystem::copy(examples + "data", folder / "data");
        std::mt19937 random(1);
        LossyWay way(free_port(), [&](std::span<const char> datagram) {
            constexpr char clock = 12 << 3 | 2;  // the tag of an Envelope's clock, which is all it has
            return random() % 4 == 0 || (!datagram.empty() && datagram[0] == clock);
        });
        const auto [hand_scene, coprocessor_scene] = scenes(
            folder, samples_at_hand ? long_grasp : "duration_s: 2 source { table { path: 'data/grip.csv' } }",
            udp_link(patient), udp_link(patient, way.port()));
        Process hand({"hand", hand_scene, "--json"});
        ASSERT_TRUE(hand.has_said("waiting"));
        Process coprocessor({"coprocessor", coprocessor_scene, "--json"});
        const auto [sent, received] = expect_all_accounted_for(hand, coprocessor);
        EXPECT_EQ(received.at("sessions"), 1);
        EXPECT_GT(received.at("events"), 10);
        EXPECT_GT(received.at("gaps"), 2);
        EXPECT_GT(received.at("lost_events"), 0);
        EXPECT_EQ(received.at("refused_frames"), 0);
    }
}

TEST(TwoProcesses, TryAHandshakeAgainThatMetWithSilence) {
    const Folder folder;
    std::atomic<bool> opens = false;
    LossyWay way(free_port(), [&](std::span<const char> datagram) {
        return datagram.size() > 1 && !opens;  // requests pass
    });
    const auto [hand_scene, coprocessor_scene] =
        scenes(folder, short_grasp, udp_link(patient), udp_link(patient, way.port()));
    Process hand({"hand", hand_scene, "--json"});
    Process coprocessor({"coprocessor", coprocessor_scene, "--json"});
    EXPECT_TRUE(coprocessor.has_said("nothing has come from the peer")) << coprocessor.err();
    opens = true;
    EXPECT_EQ(coprocessor.wait(), 0) << coprocessor.err();
    EXPECT_EQ(hand.wait(), 0) << hand.err();
    EXPECT_EQ(Json::parse(coprocessor.out())["sessions"], 1);
    EXPECT_EQ(Json::parse(coprocessor.out())["broken_sessions"], 0);
}

TEST(TwoProcesses, GiveUpOnAHandshakeThatMeetsWithSilenceInTheEnd) {
    const Folder folder;
    LossyWay way(free_port(), [&](std::span<const char> datagram) { return datagram.size() > 1; });
    const auto [hand_scene, coprocessor_scene] =
        scenes(folder, short_grasp, udp_link(), udp_link("connect_s: 4", way.port()));
    Process hand({"hand", hand_scene});
    ASSERT_TRUE(hand.has_said("waiting")) << hand.err();
    Process coprocessor({"coprocessor", coprocessor_scene});
    EXPECT_EQ(coprocessor.wait(), 1);
    EXPECT_NE(coprocessor.err().find("nothing has come from the peer"), std::string::npos)
        << coprocessor.err();
}

// The samples are the coprocessor's: on a busy machine a hand may stay safe and close on nothing.
// A kernel worker passes on what is written to a pseudo-terminal, and on a busy machine it may stall for a
// second. Two ends that have heard nothing for that long may try again.
TEST(TwoProcesses, MeetOverASerialLine) {
    const Folder folder;
    make_keys(folder);
    std::filesystem::copy(examples + "data", folder / "data");
    const std::string recorded = "duration_s: 3 source { table { path: 'data/grip.csv' } } ";
    asio::io_context io;
    SerialLine line(io);
    std::thread carrier([&] { io.run(); });
    const auto [hand_scene, coprocessor_scene] = scenes(
        folder, recorded, "link { serial { device: '" + line.first() + "' } keys: 'keys' " + patient + " }",
        "link { serial { device: '" + line.second() + "' } keys: 'keys' " + patient + " }");
    for (int attempts_left = 4; attempts_left >= 0; --attempts_left) {
        Process hand({"hand", hand_scene, "--json"});
        Process coprocessor({"coprocessor", coprocessor_scene, "--json"});
        coprocessor.wait();
        hand.wait();
        if (attempts_left > 0 && hand.err().find("nothing has come from the peer") != std::string::npos)
            continue;
        const auto [sent, received] = expect_all_accounted_for(hand, coprocessor);
        EXPECT_GT(sent.at("events"), 50);
        EXPECT_EQ(received.at("sessions"), 1);
        break;
    }
    io.stop();
    carrier.join();
}

TEST(TwoProcesses, RefuseToOpenWithoutTheKeyTheyNeed) {
    const std::vector<std::pair<std::string, std::string>> cases{
        {udp_link(sealed), ".crt: No such file"},
        {"link { udp { host: '0.0.0.0' } }", "only a link with keys may"},
        {"link { serial { device: '/dev/ttyS0' } }", "afferent keys makes"},
    };
    for (const auto& [link, reason] : cases) {
        const Folder folder;
        const auto scene = write_file(folder / "s.txtpb", link).string();
        for (const char* link_end : {"hand", "coprocessor"}) {
            Process process({link_end, scene});
            EXPECT_EQ(process.wait(), 1) << link;
            EXPECT_NE(process.err().find(reason), std::string::npos) << process.err();
        }
    }
    const Folder folder;
    make_keys(folder);
    const auto scene = write_file(folder / "s.txtpb", udp_link(sealed)).string();
    ASSERT_EQ(::chmod(folder("keys/hand.key").c_str(), 0644), 0);
    Process hand({"hand", scene});
    EXPECT_EQ(hand.wait(), 1);
    EXPECT_NE(hand.err().find("chmod 600"), std::string::npos) << hand.err();
}

TEST(TwoProcesses, RefuseLockstepWhereMessagesMayBeLost) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", udp_link()).string();
    for (const char* link_end : {"hand", "coprocessor"}) {
        Process process({link_end, scene, "--lockstep"});
        EXPECT_EQ(process.wait(), 1);
        EXPECT_NE(process.err().find("may lose some"), std::string::npos) << process.err();
    }
}

TEST(TwoProcesses, EndTogetherOnCtrlCAtTheHand) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", "duration_s: 60 " + unix_link(patient)).string();
    Process hand({"hand", scene, "--json"});
    Process coprocessor({"coprocessor", scene, "--json"});
    ASSERT_TRUE(coprocessor.has_said("the hand is there"));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    hand.signal(SIGINT);
    EXPECT_EQ(hand.wait(), 130) << hand.err();
    EXPECT_NE(hand.err().find("the session has ended: interrupted"), std::string::npos) << hand.err();
    EXPECT_EQ(coprocessor.wait(), 1) << coprocessor.err();
    EXPECT_NE(coprocessor.err().find("the session was interrupted before the scene's end"), std::string::npos)
        << coprocessor.err();
    for (const std::string& told : {hand.err(), coprocessor.err()})
        EXPECT_EQ(told.find("this is the end of the scene"), std::string::npos) << told;
    const Json sent = Json::parse(coprocessor.out());
    const Json received = Json::parse(hand.out());
    EXPECT_EQ(sent.at("complete"), false);
    EXPECT_EQ(received.at("events").get<int>() + received.at("lost_events").get<int>(), sent.at("events"));
    EXPECT_EQ(received.at("packets"), sent.at("packets"));
}

TEST(TwoProcesses, LeaveAHandThatIsSafeOnCtrlCAtTheCoprocessor) {
    const Folder folder;
    const auto scene =
        write_file(folder / "s.txtpb", "duration_s: 60 " + seed_of_its_own() + unix_link(less_patient))
            .string();
    Process hand({"hand", scene, "--json"});
    Process coprocessor({"coprocessor", scene, "--json"});
    ASSERT_TRUE(coprocessor.has_said("the hand is there"));
    ASSERT_TRUE(comes_to_operate(scene)) << hand.err();
    coprocessor.signal(SIGINT);
    EXPECT_EQ(coprocessor.wait(), 130) << coprocessor.err();
    EXPECT_TRUE(hand.has_said("safe state: no packet for 1200 ms: the session has ended")) << hand.err();
    hand.signal(SIGINT);
    EXPECT_EQ(hand.wait(), 130) << hand.err();
    const Json sent = Json::parse(coprocessor.out());
    const Json received = Json::parse(hand.out());
    EXPECT_EQ(received.at("events").get<int>() + received.at("lost_events").get<int>(), sent.at("events"));
    EXPECT_EQ(received.at("packets"), sent.at("packets"));
}

TEST(TwoProcesses, GiveUpOnAnAbsentPeerAfterTheScenesPatience) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", unix_link("connect_s: 0.3")).string();
    Process coprocessor({"coprocessor", scene});
    EXPECT_EQ(coprocessor.wait(), 1);
    EXPECT_NE(coprocessor.err().find("hand.sock"), std::string::npos) << coprocessor.err();
}

TEST(TwoProcesses, RefuseALinkThatIsNoneBetweenProcesses) {
    for (const char* link : {"link { in_process {} }", "link { tcp {} keys: 'nowhere' }"}) {
        const Folder folder;
        const auto scene = write_file(folder / "s.txtpb", link).string();
        for (const char* link_end : {"hand", "coprocessor"}) {
            Process process({link_end, scene});
            EXPECT_EQ(process.wait(), 1) << link;
            EXPECT_TRUE(process.err().find("the link") != std::string::npos ||
                        process.err().find("nowhere") != std::string::npos)
                << process.err();
        }
    }
}

TEST(TwoProcesses, RefuseAPeerOfAnotherScene) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", short_grasp + unix_link(patient)).string();
    Process hand({"hand", scene});
    ASSERT_TRUE(hand.has_said("waiting"));
    Process coprocessor({"coprocessor", scene, "--seed", "77"});
    EXPECT_EQ(coprocessor.wait(), 1);
    EXPECT_NE(coprocessor.err().find("the scenes differ in seed"), std::string::npos) << coprocessor.err();
    EXPECT_TRUE(hand.has_said("the scenes differ in seed")) << hand.err();
    // The hand goes on waiting for the right one.
    Process right({"coprocessor", scene});
    EXPECT_EQ(right.wait(), 0) << right.err();
    EXPECT_EQ(hand.wait(), 0) << hand.err();
}

class DeathsOf : public testing::TestWithParam<const char*> {
  protected:
    DeathsOf() { make_keys(folder_); }
    static std::string link() {
        const std::string transport = GetParam();
        return transport == "unix"  ? unix_link(less_patient)
               : transport == "udp" ? udp_link(less_patient)
                                    : udp_link(sealed + " " + less_patient);
    }

    Folder folder_;
};
INSTANTIATE_TEST_SUITE_P(Transports, DeathsOf, testing::Values("unix", "udp", "udp_sealed"),
                         [](const auto& transport) { return std::string(transport.param); });

TEST_P(DeathsOf, TheCoprocessorAreSurvived) {
    const auto scene =
        write_file(folder_ / "s.txtpb", "duration_s: 14 " + seed_of_its_own() + link()).string();
    Process hand({"hand", scene, "--json"});
    {
        Process coprocessor({"coprocessor", scene});
        ASSERT_TRUE(hand.has_said("the coprocessor is there"));
        ASSERT_TRUE(comes_to_operate(scene)) << hand.err();
        coprocessor.signal(SIGKILL);
        EXPECT_EQ(coprocessor.wait(), -SIGKILL);
    }
    EXPECT_TRUE(hand.has_said("safe state")) << hand.err();
    Process again({"coprocessor", scene});
    EXPECT_EQ(again.wait(), 0) << again.err();
    EXPECT_EQ(hand.wait(), 1) << hand.err();
    EXPECT_NE(hand.err().find("1 session broke off before the scene's end"), std::string::npos) << hand.err();
    const Json received = Json::parse(hand.out());
    EXPECT_EQ(received.at("sessions"), 2);
    EXPECT_EQ(received.at("broken_sessions"), 1);
    EXPECT_EQ(received.at("safe_states"), 1);
}

TEST_P(DeathsOf, TheHandAreSurvived) {
    // Over datagrams it takes a second of silence to know.
    const auto scene = write_file(folder_ / "s.txtpb", "duration_s: 9 " + link()).string();
    auto hand = std::make_unique<Process>(std::vector<std::string>{"hand", scene});
    Process coprocessor({"coprocessor", scene, "--json"});
    ASSERT_TRUE(coprocessor.has_said("the hand is there"));
    hand->signal(SIGKILL);
    hand->wait();
    EXPECT_TRUE(coprocessor.has_said("broken off")) << coprocessor.err();
    hand = std::make_unique<Process>(std::vector<std::string>{"hand", scene});
    EXPECT_EQ(coprocessor.wait(), 1) << coprocessor.err();
    EXPECT_EQ(hand->wait(), 0) << hand->err();
    EXPECT_EQ(Json::parse(coprocessor.out())["sessions"], 2);
}

TEST(TwoProcesses, AreNotHarmedByAFloodOfForgedDatagrams) {
    for (const std::string& more : {std::string(), sealed}) {
        const Folder folder;
        make_keys(folder);
        const auto scene =
            write_file(folder / "s.txtpb", short_grasp + udp_link(more + " " + patient)).string();
        Process hand({"hand", scene, "--json"});
        ASSERT_TRUE(hand.has_said("waiting"));
        std::atomic<bool> over = false;
        std::thread stranger([&] {
            const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
            sockaddr_in address{};
            address.sin_family = AF_INET;
            address.sin_port = htons(free_port());
            address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
            const std::string garbage(200, '\x03');
            while (!over) {
                for (std::size_t size = 1; size < garbage.size(); size += 20)
                    ::sendto(socket, garbage.data(), size, 0, reinterpret_cast<const sockaddr*>(&address),
                             sizeof address);
                std::this_thread::sleep_for(std::chrono::milliseconds(5));
            }
            ::close(socket);
        });
        Process coprocessor({"coprocessor", scene, "--json"});
        const auto [sent, received] = expect_all_accounted_for(hand, coprocessor);
        over = true;
        stranger.join();
        EXPECT_EQ(received.at("sessions"), 1);
        EXPECT_EQ(received.at("safe_states"), 0);
        EXPECT_EQ(received.at("refused_frames"), 0);
        EXPECT_GT(received.at("forged_datagrams"), 500);
    }
}

TEST(TwoProcesses, AreNotHarmedByGarbage) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", short_grasp + unix_link(patient)).string();
    Process hand({"hand", scene});
    ASSERT_TRUE(hand.has_said("waiting"));
    const int stranger = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    folder("hand.sock").copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::connect(stranger, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    const std::string garbage(10'000, '\xff');
    EXPECT_GT(::send(stranger, garbage.data(), garbage.size(), MSG_NOSIGNAL), 0);
    ::close(stranger);
    Process coprocessor({"coprocessor", scene});
    EXPECT_EQ(coprocessor.wait(), 0) << coprocessor.err();
    EXPECT_EQ(hand.wait(), 0) << hand.err();
}

std::size_t times_said(const Process& process, const std::string& text) {
    std::size_t count = 0;
    const std::string all = process.err();
    for (auto at = all.find(text); at != std::string::npos; at = all.find(text, at + 1)) ++count;
    return count;
}

// Another has the hand by then.
TEST(TwoProcesses, ACoprocessorThatWasHeldUpTriesAgainWithoutHaste) {
    const Folder folder;
    const auto scene =
        write_file(folder / "s.txtpb", "duration_s: 12 " + unix_link("connect_s: 1.5 " + less_patient))
            .string();
    Process hand({"hand", scene, "--json"});
    Process first({"coprocessor", scene});
    ASSERT_TRUE(first.has_said("the hand is there"));
    first.signal(SIGSTOP);
    ASSERT_TRUE(hand.has_said("broken off")) << hand.err();
    Process second({"coprocessor", scene});
    ASSERT_TRUE(second.has_said("the hand is there")) << second.err();
    first.signal(SIGCONT);
    EXPECT_EQ(first.wait(), 1);
    EXPECT_EQ(times_said(first, "session has broken off"), 2U) << first.err();
    EXPECT_GE(times_said(first, "another coprocessor is connected"), 2U) << first.err();
    second.signal(SIGINT);
    EXPECT_EQ(second.wait(), 130);
    EXPECT_EQ(hand.wait(), 1) << hand.err();
    // Four times a second, and not as fast as it goes.
    EXPECT_LT(Json::parse(hand.out()).at("refused_peers").get<int>(), 15);
}

// The hand takes the second as soon as the first has gone.
TEST(TwoProcesses, ASecondCoprocessorOverDatagramsWaitsForItsTurn) {
    const Folder folder;
    make_keys(folder);
    for (const std::string& link : {udp_link("connect_s: 60"), udp_link("connect_s: 60 " + sealed)}) {
        const auto scene = write_file(folder / "s.txtpb", "duration_s: 60 " + link).string();
        Process hand({"hand", scene});
        Process first({"coprocessor", scene});
        ASSERT_TRUE(first.has_said("the hand is there")) << first.err();
        Process second({"coprocessor", scene});
        ASSERT_TRUE(second.has_said("another coprocessor is connected")) << second.err();
        first.signal(SIGINT);
        EXPECT_EQ(first.wait(), 130);
        EXPECT_TRUE(second.has_said("the hand is there")) << second.err();
        for (Process* process : {&second, &hand}) {
            process->signal(SIGINT);
            EXPECT_GT(process->wait(), 0);
        }
    }
}

TEST(TwoProcesses, TellWhyASessionHasEnded) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", "duration_s: 0.3 " + unix_link(patient)).string();
    Process hand({"hand", scene});
    Process coprocessor({"coprocessor", scene});
    EXPECT_EQ(coprocessor.wait(), 0);
    EXPECT_EQ(hand.wait(), 0);
    for (const Process* process : {&hand, &coprocessor})
        EXPECT_EQ(times_said(*process, "the session has ended: this is the end of the scene"), 1U)
            << process->err();
}

// The summary is told, and everything else is written.
TEST(TwoProcesses, GoOnWithoutRoomForTheirRecording) {
    const Folder folder;
    const auto scene = write_file(folder / "s.txtpb", "duration_s: 0.3 " + unix_link(patient)).string();
    Process hand({"hand", scene, "--record", "/dev/full", "--out", folder("hand"), "--json"});
    Process coprocessor({"coprocessor", scene, "--record", "/dev/full", "--json"});
    for (Process* process : {&hand, &coprocessor}) {
        EXPECT_EQ(process->wait(), 1);
        EXPECT_NE(process->err().find("No space left"), std::string::npos) << process->err();
        EXPECT_EQ(Json::parse(process->out())["complete"], true);
    }
    EXPECT_TRUE(std::filesystem::exists(folder / "hand/summary.json"));
}

TEST(TwoProcesses, NameWhatIsNoUtf8AndDoNotNeedAPlaceForTheirStatus) {
    const Folder folder;
    const auto scene =
        write_file(folder / "s.txtpb", "name: \"\\377\" duration_s: 0.3 " + unix_link(patient)).string();
    const std::string before = std::getenv("XDG_RUNTIME_DIR") ? std::getenv("XDG_RUNTIME_DIR") : "";
    const std::filesystem::path longest = folder / std::string(120, 'x');
    std::filesystem::create_directory(longest);
    ::setenv("XDG_RUNTIME_DIR", longest.c_str(), 1);
    Process hand({"hand", scene, "--json"});
    Process coprocessor({"coprocessor", scene, "--json"});
    before.empty() ? ::unsetenv("XDG_RUNTIME_DIR") : ::setenv("XDG_RUNTIME_DIR", before.c_str(), 1);
    EXPECT_EQ(coprocessor.wait(), 0) << coprocessor.err();
    EXPECT_EQ(hand.wait(), 0) << hand.err();
    EXPECT_EQ(Json::parse(hand.out())["complete"], true);
}

TEST(TwoProcesses, TellTheirStatusAndThatOfWhatIsBetweenThem) {
    const Folder folder;
    const auto scene =
        write_file(folder / "s.txtpb", "duration_s: 60 " + unix_link("channel { latency_ms: 1 }")).string();
    Process hand({"hand", scene});
    Process channel({"channel", scene});
    ASSERT_TRUE(channel.has_said("until Ctrl-C")) << channel.err();
    Process coprocessor({"coprocessor", scene});
    ASSERT_TRUE(coprocessor.has_said("the hand is there")) << coprocessor.err();
    // A process that is held up may not answer in time, so it is asked again.
    EXPECT_TRUE(comes_true([&] {
        Process status({"link", "status", scene, "--json"});
        EXPECT_EQ(status.wait(), 0) << status.err();
        Json all = Json::parse(status.out());
        return all["coprocessor"]["session"] == "open" && all["hand"]["session"] == "open" &&
               all["channel"].contains("to_hand") && all["channel"]["to_hand"]["frames"] > 1;
    })) << hand.err()
        << channel.err() << coprocessor.err();
    // A stopped process does not stop the one that asks it.
    hand.signal(SIGSTOP);
    Process again({"link", "status", scene, "--json"});
    EXPECT_EQ(again.wait(), 0) << again.err();
    EXPECT_EQ(Json::parse(again.out())["hand"]["session"], "does not answer");
}

}  // namespace
}  // namespace afferent
