#include "afferent/nodes/ability_hand_line.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <thread>
#include <utility>

#include "afferent/io/links/serial_stream.hpp"
#include "afferent/nodes/ability_hand_driver.hpp"
#include "afferent/nodes/real_time.hpp"
#include "afferent/runtime/latest.hpp"
#include "afferent/runtime/slot_ring.hpp"

namespace afferent {
namespace {

using Clock = std::chrono::steady_clock;

// A fraction of a second of scans, for a thread that is late.
constexpr std::size_t waiting_scans = 256;
constexpr std::size_t waiting_notes = 64;

// How often the thread looks for its end, and how long it waits before it opens a line again.
constexpr std::chrono::milliseconds longest_look{10};
constexpr std::chrono::milliseconds pause_before_opening{200};

class AbilityHandLine final : public HandDevice {
  public:
    AbilityHandLine(const Plan& plan, std::string device)
        : device_(std::move(device)),
          baud_(plan.scene.hand.ability_hand->baud),
          driver_(ability_hand_driver_parameters(plan), Clock::now()),
          scans_(waiting_scans, {MonotonicTime(), std::vector<double>(ability_hand::sensors)}),
          notes_(waiting_notes) {}

    ~AbilityHandLine() override {
        ends_.store(true, std::memory_order_relaxed);
        if (thread_.joinable()) thread_.join();
    }

    Result<void> open() {
        AFFERENT_TRY(line, SerialStream::open(device_, baud_));
        line_.emplace(std::move(line));
        return success();
    }

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
    std::optional<std::string> next_note() override {
        std::string* const note = notes_.next();
        if (!note) return std::nullopt;
        std::string text = std::move(*note);
        notes_.pop();
        return text;
    }
    const HandReadings& readings() override { return readings_.read(); }
    std::uint64_t dropped_scans() const noexcept override { return dropped_.load(std::memory_order_relaxed); }
    void take_zero() noexcept override { zero_.store(true, std::memory_order_relaxed); }

  private:
    void run() {
        driver_.begin_line(Clock::now());
        while (!ends_.load(std::memory_order_relaxed)) {
            const MonotonicTime now = Clock::now();
            driver_.follow(commands_.read());
            if (zero_.exchange(false, std::memory_order_relaxed)) driver_.take_zero(now);
            if (line_)
                exchange(now);
            else
                try_again(now);
            // Notes first: who reads a count finds what is said of it.
            while (auto note = driver_.next_note()) tell(std::move(*note));
            readings_.tell(driver_.readings(Clock::now()));
        }
    }

    // Writes what is due and reads what has come.
    void exchange(MonotonicTime now) {
        const auto request = driver_.poll(now);
        // A line that takes no more has lost the request, which nobody then answers.
        if (!request.empty() && !line_->write(request)) return lose();
        const auto count =
            line_->read(bytes_, std::clamp<Duration>(driver_.wake() - Clock::now(), 0ns, longest_look));
        if (!count) return lose();
        driver_.read(Clock::now(), std::span(bytes_).first(*count),
                     [this](MonotonicTime at, std::span<const double> forces_n) { keep(at, forces_n); });
    }

    void lose() {
        line_.reset();
        driver_.lost_line();
        tell("the line to the hand has failed; it is opened again as soon as it is there");
        attempt_at_ = Clock::now() + pause_before_opening;
    }

    void try_again(MonotonicTime now) {
        if (now >= attempt_at_) {
            attempt_at_ = now + pause_before_opening;
            if (open()) {
                driver_.begin_line(Clock::now());
                return tell("the line to the hand is there again");
            }
        }
        std::this_thread::sleep_for(longest_look);
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
        if (std::string* const slot = notes_.free_slot()) {
            *slot = std::move(note);
            notes_.push();
            arrived_();
        }
    }

    const std::string device_;
    const std::uint32_t baud_;
    AbilityHandDriver driver_;
    std::optional<SerialStream> line_;
    MonotonicTime attempt_at_{};
    std::array<std::byte, 512> bytes_{};
    std::function<void()> arrived_;
    Latest<DeviceCommand> commands_;
    Latest<HandReadings> readings_;
    SlotRing<HandScan> scans_;
    bool taken_ = false;
    SlotRing<std::string> notes_;
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
