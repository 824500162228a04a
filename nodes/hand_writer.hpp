// Writes what a hand does: to the scene's outputs, to a recording, and to a listener.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "afferent/nodes/hand_record.hpp"
#include "afferent/nodes/hand_recording.hpp"
#include "afferent/nodes/outputs.hpp"

namespace afferent {

class HandWriter {
  public:
    struct Listener {
        std::function<void(const ControllerStep&)> step = [](const auto&) {};
        // The hand starts over at another place of the scene; called before its first step there.
        std::function<void()> starting_over = [] {};
        // The grip has become safe; why.
        std::function<void(const std::string&)> safe = [](const auto&) {};
    };

    HandWriter() = default;
    explicit HandWriter(Outputs outputs) : outputs_(std::move(outputs)) {}
    HandWriter(Outputs outputs, Listener listener)
        : outputs_(std::move(outputs)), listener_(std::move(listener)) {}

    const Outputs& outputs() const noexcept { return outputs_; }
    // Records everything from here on.
    void record(HandRecording recording) { recording_ = std::move(recording); }
    bool records() const noexcept { return recording_.has_value(); }

    // Writes the records that wait.
    void write(HandRecords& records) {
        while (const HandRecord* record = records.next()) {
            write(*record);
            records.pop();
        }
    }
    // Nothing follows: the hand of the records stopped at that time. Returns the error of what could not be
    // written.
    Result<void> close(const HandRecords& records, TimePoint time);

  private:
    void write(const HandRecord& record);
    void record(const HandRecord& record);
    void notice_losses(std::uint64_t number);

    Outputs outputs_;
    Listener listener_;
    std::optional<HandRecording> recording_;
    bool begun_ = false;
    // The number of the next record, if none is lost.
    std::uint64_t number_ = 0;
    std::uint64_t step_ = 0;  // the step that was due after the last record
    TimePoint time_ = scene_start;
    bool incomplete_ = false;  // the recording ends where a record was lost
};

}  // namespace afferent
