#include "afferent/nodes/ability_hand_line.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <thread>
#include <utility>

#include "afferent/nodes/ability_hand_driver.hpp"
#include "afferent/nodes/real_time.hpp"
#include "afferent/nodes/reopened_line.hpp"
#include "afferent/runtime/latest.hpp"
#include "afferent/runtime/slot_ring.hpp"

namespace afferent {
namespace {

using Clock = std::chrono::steady_clock;

// A fraction of a second of scans, for a thread that is late.
constexpr std::size_t waiting_scans = 256;

class AbilityHandLine final : public HandDevice {
  public:
    AbilityHandLine(const Plan& plan, std::string device)
        : line_(std::move(device), plan.scene.hand.ability_hand->baud, "hand"),
          driver_(ability_hand_driver_parameters(plan), Clock::now()),
          scans_(waiting_scans, {MonotonicTime(), std::vector<double>(ability_hand::sensors)}) {}

    ~AbilityHandLine() override {
        ends_.store(true, std::memory_order_relaxed);
        if (thread_.joinable()) thread_.join();
    }

    Result<void> open() { return line_.open(); }

    void start(std::function<void()> arrived) override {
        arrived_ = std::move(arrived);
        thread_ = std::thread([this] { run(); });
        give_real_time_priority(thread_);
    }
    void command(const DeviceCommand& command) noexcept override { commands_.tell(command); }
    const HandScan* next_scan() override {
        if (std::exchange(taken_, false)) scans_.pop();
        const HandScan* const scan = scans_.next();
        taken_ = scan != nullptr;
        return scan;
    }
    std::optional<std::string> next_note() override { return line_.next_note(); }
    const HandReadings& readings() override { return readings_.read(); }
    std::uint64_t dropped_scans() const noexcept override { return dropped_.load(std::memory_order_relaxed); }
    void take_zero() noexcept override { zero_.store(true, std::memory_order_relaxed); }

  private:
    void run() {
        while (!ends_.load(std::memory_order_relaxed)) {
            const MonotonicTime now = Clock::now();
            driver_.follow(commands_.read());
            if (zero_.exchange(false, std::memory_order_relaxed)) driver_.take_zero(now);
            if (line_.is_open())
                exchange(now);
            else if (line_.try_again())
                begin_again();
            // Notes first: who reads a count finds what is said of it.
            while (auto note = driver_.next_note()) tell(std::move(*note));
            readings_.tell(driver_.readings(Clock::now()));
        }
    }

    // Writes what is due and reads what has come.
    void exchange(MonotonicTime now) {
        const auto request = driver_.poll(now);
        // A line that takes no more has lost the request, which nobody then answers.
        if (!request.empty() && !line_.write(request)) return lost();
        const auto count = line_.read(
            bytes_, std::clamp<Duration>(driver_.wake() - Clock::now(), 0ns, ReopenedLine::longest_look));
        if (!count) return lost();
        driver_.read(Clock::now(), std::span(bytes_).first(*count),
                     [this](MonotonicTime at, std::span<const double> forces_n) { keep(at, forces_n); });
    }

    void lost() {
        driver_.lost_line();
        arrived_();
    }

    void begin_again() {
        driver_.begin_line();
        arrived_();
    }

    void keep(MonotonicTime at, std::span<const double> forces_n) {
        HandScan* const slot = scans_.free_slot();
        if (!slot) {
            dropped_.fetch_add(1, std::memory_order_relaxed);
            return;
        }
        slot->at = at;
        slot->forces_n.assign(forces_n.begin(), forces_n.end());
        scans_.push();
        arrived_();
    }

    void tell(std::string note) {
        if (line_.tell(std::move(note))) arrived_();
    }

    ReopenedLine line_;
    AbilityHandDriver driver_;
    std::array<std::byte, 512> bytes_{};
    std::function<void()> arrived_;
    Latest<DeviceCommand> commands_;
    Latest<HandReadings> readings_;
    SlotRing<HandScan> scans_;
    bool taken_ = false;
    std::atomic<std::uint64_t> dropped_{0};
    std::atomic<bool> zero_{false};
    std::atomic<bool> ends_{false};
    std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<HandDevice>> open_ability_hand(const Plan& plan) {
    const std::string device = plan.scene.resolve(plan.scene.hand.ability_hand->port).string();
    auto line = std::make_unique<AbilityHandLine>(plan, device);
    if (const auto opened = line->open(); !opened)
        return Error{opened.error().kind, plan.scene.file + ": hand.ability_hand.port: " + device + ": " +
                                              opened.error().text +
                                              "; without a hand, `afferent emulate` has one to try"};
    return std::unique_ptr<HandDevice>(std::move(line));
}

}  // namespace afferent
