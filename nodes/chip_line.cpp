#include "afferent/nodes/chip_line.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <thread>
#include <utility>

#include "afferent/nodes/real_time.hpp"
#include "afferent/nodes/reopened_line.hpp"
#include "afferent/runtime/slot_ring.hpp"

namespace afferent {
namespace {

// A second or more of a fast line.
constexpr std::size_t reads_kept = 1024;

class ChipLine final : public ChipDevice {
  public:
    ChipLine(std::string device, std::uint32_t baud)
        : line_(std::move(device), baud, "chip"), reads_(reads_kept) {}

    ~ChipLine() override {
        ends_.store(true, std::memory_order_relaxed);
        if (thread_.joinable()) thread_.join();
    }

    Result<void> open() { return line_.open(); }

    void start() {
        thread_ = std::thread([this] { run(); });
        give_real_time_priority(thread_);
    }

    const ChipBytes* next() override {
        if (std::exchange(taken_, false)) reads_.pop();
        const ChipBytes* const bytes = reads_.next();
        taken_ = bytes != nullptr;
        return bytes;
    }
    std::optional<std::string> next_note() override { return line_.next_note(); }

  private:
    void run() {
        while (!ends_.load(std::memory_order_relaxed)) {
            if (!line_.is_open()) {
                (void)line_.try_again();
            } else if (const auto count = line_.read(bytes_, ReopenedLine::longest_look)) {
                if (*count > 0) keep(std::span(bytes_).first(*count));
            }
        }
    }

    void keep(std::span<const std::byte> bytes) {
        ChipBytes* const slot = reads_.free_slot();
        if (!slot) return;
        slot->at = std::chrono::steady_clock::now();
        slot->bytes.assign(bytes.begin(), bytes.end());
        reads_.push();
    }

    ReopenedLine line_;
    std::array<std::byte, 512> bytes_{};
    SlotRing<ChipBytes> reads_;
    bool taken_ = false;
    std::atomic<bool> ends_{false};
    std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<ChipDevice>> open_chip_line(const Plan& plan) {
    const auto& chip = std::get<scene::Chip>(plan.scene.source);
    const std::string device = plan.scene.resolve(chip.device).string();
    auto line = std::make_unique<ChipLine>(device, chip.baud);
    if (const auto opened = line->open(); !opened)
        return Error{opened.error().kind,
                     plan.scene.file + ": source.chip.device: " + device + ": " + opened.error().text};
    line->start();
    return std::unique_ptr<ChipDevice>(std::move(line));
}

}  // namespace afferent
