// What pressed the skin when: the forces on its elements at equal distances of time, as scans tell them.
#pragma once

#include <cstdint>
#include <vector>

#include "afferent/runtime/scan.hpp"

namespace afferent {

class PressureFrames {
  public:
    struct Pressed {
        std::uint32_t element;
        float force_n;
    };

    // At first, first + interval, ...: as many as `count`.
    PressureFrames(std::uint32_t elements, TimePoint first, Duration interval, std::size_t count);

    // In the order of time. An element keeps its force until the next scan of it.
    void scan(const Scan& scan);
    // No more scans come: what lies before `end` is as the last scan has left it.
    void finish(TimePoint end);

    // The elements under a force at each of these times, in no order. Fewer than asked for before finish().
    const std::vector<std::vector<Pressed>>& frames() const noexcept { return frames_; }
    // How many elements these are, of all frames so far.
    std::uint64_t pressed() const noexcept { return all_pressed_; }

  private:
    void keep_until(TimePoint time);

    TimePoint first_;
    Duration interval_;
    std::size_t count_;
    std::vector<float> forces_n_;
    std::vector<std::uint32_t> pressed_;  // those with a force, and perhaps some that have none any more
    std::vector<std::uint8_t> listed_;    // whether an element is among them
    std::vector<std::vector<Pressed>> frames_;
    std::uint64_t all_pressed_ = 0;
};

}  // namespace afferent
