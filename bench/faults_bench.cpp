#include "bench/faults_bench.hpp"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iomanip>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "afferent/nodes/hello.hpp"
#include "bench/attackers.hpp"
#include "bench/child_process.hpp"
#include "bench/table_file.hpp"

namespace afferent::bench {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// What each row should keep to, on two cores.
constexpr double target_p99_ms = 2;
constexpr double target_max_ms = 10;
constexpr double target_lost_pct = 1;
constexpr double target_rss_mb = 64;

constexpr std::uint64_t idle_connections = 2000;
constexpr double datagrams_per_s = 50'000;

struct Fault {
    std::string name;
    std::function<std::uint64_t(const Victim&, const std::stop_token&)> attack;  // empty: none
    bool has_coprocessor = true;
    bool is_rate = true;  // or a number
};

std::vector<Fault> faults_on(const std::string& transport) {
    const bool datagrams = transport == "udp" || transport == "udp_sealed";
    std::vector<Fault> faults{{.name = "none", .attack = {}}};
    if (!datagrams) faults.push_back({.name = "connects", .attack = connect_and_hang_up});
    if (transport == "tls") faults.push_back({.name = "handshakes", .attack = begin_handshakes});
    if (!datagrams)
        faults.push_back({.name = "idle_connections",
                          .attack =
                              [](const Victim& victim, const std::stop_token& stop) {
                                  return hold_idle_connections(victim, idle_connections, stop);
                              },
                          .is_rate = false});
    for (const std::size_t bytes : {64U, 1400U})
        if (datagrams)
            faults.push_back({.name = "datagrams_" + std::to_string(bytes),
                              .attack = [bytes](const Victim& victim, const std::stop_token& stop) {
                                  return send_datagrams(victim, bytes, datagrams_per_s, stop);
                              }});
    if (transport == "udp_sealed") {
        faults.push_back({.name = "hellos", .attack = [](const Victim& victim, const std::stop_token& stop) {
                              return send_hellos(victim, datagrams_per_s, stop);
                          }});
        faults.push_back({.name = "cookies", .attack = return_cookies});
    }
    faults.push_back({.name = "clocks", .attack = send_clocks, .has_coprocessor = false});
    faults.push_back({.name = "byes", .attack = open_and_say_bye, .has_coprocessor = false});
    faults.push_back({.name = "byes_first", .attack = say_bye_first, .has_coprocessor = false});
    return faults;
}

// A folder of the benchmark's own, gone with it.
class WorkFolder {
  public:
    WorkFolder() {
        std::string name = (fs::temp_directory_path() / "afferent-faults-XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot be made");
        path_ = name;
    }
    ~WorkFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    WorkFolder(const WorkFolder&) = delete;
    WorkFolder& operator=(const WorkFolder&) = delete;
    fs::path operator/(const std::string& name) const { return path_ / name; }
    const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};

// A port that was free a moment ago.
std::uint16_t free_port() {
    namespace ip = boost::asio::ip;
    boost::asio::io_context io;
    return ip::tcp::acceptor(io, {ip::address_v4::loopback(), 0}).local_endpoint().port();
}

// A grasp that begins at once and holds to the scene's end.
Scene grasp(const std::string& transport, std::uint16_t port, double duration_s) {
    Scene scene;
    scene.duration_s = duration_s;
    scene.record.picture = false;
    scene.hand.user.close_at_s = 0.1;
    scene.hand.user.hold_for_s = duration_s;
    if (transport == "unix")
        scene.link.transport = scene::UnixSocket{.path = "hand.sock"};
    else if (transport == "udp" || transport == "udp_sealed")
        scene.link.transport = scene::Udp{.port = port};
    else
        scene.link.transport = scene::Tcp{.port = port};
    if (transport == "tls" || transport == "udp_sealed") scene.link.keys = "keys";
    return scene;
}

// The value of that key in the program's JSON; empty where it has none.
std::string entry(const std::string& json, const std::string& key) {
    const auto found = json.find('"' + key + "\":");
    if (found == std::string::npos) return "";
    std::string rest = json.substr(found + key.size() + 3);
    rest = rest.substr(0, rest.find_first_of(",}\n"));
    std::erase_if(rest, [](char c) { return c == ' ' || c == '"'; });
    return rest;
}

std::optional<double> figure(const std::string& json, const std::string& key) {
    const std::string text = entry(json, key);
    return text.empty() || text == "null" ? std::nullopt : std::optional(std::stod(text));
}

class Bench {
  public:
    explicit Bench(const FaultsOptions& options)
        : program_(options.program.string()), duration_s_(options.quick ? 2 : 5) {
        run({"keys", (folder_ / "keys").string()});
    }

    FaultsRow measure(const std::string& transport, const Fault& fault) {
        const std::uint16_t port = free_port();
        const fs::path file = folder_ / "scene.txtpb";
        std::ofstream(file) << grasp(transport, port, duration_s_).text();
        const Plan plan = make_plan(Scene::from_file(file), Commands::wanted);
        const auto address = hand_address(plan.scene, LinkEnd::coprocessor);
        if (!address) throw std::runtime_error(address.error().text);
        const Victim victim{plan, transport == "unix" ? (folder_ / "hand.sock").string() : "", port,
                            address.value()};

        ChildProcess hand(folder_.path(), "hand", {program_, "hand", file.string(), "--json"});
        expect(hand, "waiting for the coprocessor");
        const auto begin = Clock::now();
        ChildProcess coprocessor(folder_.path(), "coprocessor",
                                 {program_, "coprocessor", file.string(), "--json"});
        expect(coprocessor, "the hand is there");
        FaultsRow row;
        row.transport = transport;
        row.fault = fault.name;
        row.has_coprocessor = fault.has_coprocessor;
        if (!fault.has_coprocessor) {
            std::this_thread::sleep_for(milliseconds(300));
            coprocessor.signal(SIGKILL);
        }
        // Leaves time for the first events, or for the hand to become safe.
        std::this_thread::sleep_for(milliseconds(300));
        attack(fault, victim,
               begin + std::chrono::duration_cast<Clock::duration>(Interval(duration_s_ * 1e9)), hand, file,
               row);
        conclude(hand, coprocessor, row);
        return row;
    }

  private:
    void expect(const ChildProcess& child, const std::string& text) const {
        if (!child.says(text, milliseconds(5000)))
            throw std::runtime_error("a process that should say \"" + text + "\" says: " + child.err());
    }

    std::string run(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), program_);
        ChildProcess child(folder_.path(), "other", std::move(arguments));
        child.wait(milliseconds(10'000));
        return child.out();
    }

    // Lets the attack run until a little before the scene ends.
    void attack(const Fault& fault, const Victim& victim, Clock::time_point scene_end,
                const ChildProcess& hand, const fs::path& scene, FaultsRow& row) {
        std::uint64_t count = 0;
        const auto begin = Clock::now();
        Clock::time_point end;
        {
            std::jthread attacker;
            if (fault.attack)
                attacker =
                    std::jthread([&](const std::stop_token& stop) { count = fault.attack(victim, stop); });
            while (Clock::now() < scene_end - milliseconds(400)) {
                row.rss_mb = std::max(row.rss_mb, hand.peak_rss_mb().value_or(0));
                std::this_thread::sleep_for(milliseconds(20));
            }
            row.grip_state = entry(run({"link", "status", scene.string(), "--json"}), "grip_state");
            if (row.grip_state.empty()) row.grip_state = "no answer";
            row.rss_mb = std::max(row.rss_mb, hand.peak_rss_mb().value_or(0));
            end = Clock::now();
        }
        const std::chrono::duration<double> attacked = end - begin;
        row.rate = static_cast<double>(count) / (fault.is_rate ? attacked.count() : 1);
    }

    static void conclude(ChildProcess& hand, ChildProcess& coprocessor, FaultsRow& row) {
        if (!hand.wait(milliseconds(5000))) {
            hand.signal(SIGTERM);
            hand.wait(milliseconds(5000));
        }
        const std::string summary = hand.out();
        row.step_p50_ms = figure(summary, "step_lateness_p50_ms");
        row.step_p99_ms = figure(summary, "step_lateness_p99_ms");
        row.step_max_ms = figure(summary, "step_lateness_max_ms");
        if (!row.has_coprocessor) return;
        coprocessor.wait(milliseconds(5000));
        const auto sent = figure(coprocessor.out(), "events");
        const auto received = figure(summary, "events");
        if (sent && received && *sent > 0) row.events_lost_pct = 100 * (*sent - *received) / *sent;
    }

    WorkFolder folder_;
    std::string program_;
    double duration_s_;
};

std::string cell(const std::optional<double>& value, int digits) {
    if (!value) return "";
    std::ostringstream text;
    text << std::fixed << std::setprecision(digits) << *value;
    return text.str();
}

void print_head(std::ostream& report) {
    report << "How late the steps of the hand are, what is lost and what becomes of the grip.\n\n"
           << std::left << std::setw(11) << "transport" << std::setw(17) << "fault" << std::right
           << std::setw(9) << "rate" << std::setw(10) << "p50 ms" << std::setw(10) << "p99 ms"
           << std::setw(10) << "max ms" << std::setw(9) << "lost %" << std::setw(8) << "MB"
           << "  grip\n";
}

void print(const FaultsRow& row, std::ostream& report) {
    std::string missed;
    const auto check = [&](const std::optional<double>& value, double target, const char* name) {
        if (value && *value > target) missed += std::string(missed.empty() ? "  over: " : ", ") + name;
    };
    check(row.step_p99_ms, target_p99_ms, "p99");
    check(row.step_max_ms, target_max_ms, "max");
    check(row.events_lost_pct, target_lost_pct, "lost");
    check(row.rss_mb, target_rss_mb, "MB");
    report << std::left << std::setw(11) << row.transport << std::setw(17) << row.fault << std::right
           << std::setw(9) << cell(row.rate, 0) << std::setw(10) << cell(row.step_p50_ms, 3) << std::setw(10)
           << cell(row.step_p99_ms, 3) << std::setw(10) << cell(row.step_max_ms, 3) << std::setw(9)
           << cell(row.events_lost_pct, 2) << std::setw(8) << cell(row.rss_mb, 1) << "  " << row.grip_state
           << missed << std::endl;
}

bool is_as_it_must_be(const FaultsRow& row) { return row.has_coprocessor || row.grip_state == "safe"; }

}  // namespace

std::vector<FaultsRow> run_faults_bench(const FaultsOptions& options, std::ostream& report) {
    TableFile table(options.out / "faults.csv", {"transport", "fault", "rate", "step_p99_ms", "step_max_ms",
                                                 "events_lost_pct", "rss_mb", "grip_state"});
    Bench bench(options);
    std::vector<FaultsRow> wrong;
    print_head(report);
    const std::vector<std::string> transports =
        options.quick ? std::vector<std::string>{"unix", "udp"}
                      : std::vector<std::string>{"tcp", "tls", "unix", "udp", "udp_sealed"};
    for (const std::string& transport : transports)
        for (const Fault& fault : faults_on(transport)) {
            const FaultsRow row = bench.measure(transport, fault);
            print(row, report);
            table.row({row.transport, row.fault, cell(row.rate, 0), cell(row.step_p99_ms, 3),
                       cell(row.step_max_ms, 3), cell(row.events_lost_pct, 2), cell(row.rss_mb, 1),
                       row.grip_state});
            if (!is_as_it_must_be(row)) wrong.push_back(row);
        }
    table.close();
    report << "\nTargets on two cores: p99 " << target_p99_ms << " ms, max " << target_max_ms << " ms, lost "
           << target_lost_pct << " %, " << target_rss_mb
           << " MB. The rows without a fault tell what this machine does by itself.\n";
    return wrong;
}

}  // namespace afferent::bench
