// Writes what a hand does: to the scene's outputs, to a recording, and to an observer.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "afferent/nodes/hand_record.hpp"
#include "afferent/nodes/hand_recording.hpp"
#include "afferent/nodes/observer.hpp"
#include "afferent/nodes/outputs.hpp"

namespace afferent {

class HandWriter {
  public:
    HandWriter() = default;
    explicit HandWriter(Outputs outputs) : outputs_(std::move(outputs)) {}
    HandWriter(Outputs outputs, Observer observer)
        : outputs_(std::move(outputs)), observer_(std::move(observer)) {}

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
    Observer observer_;
    std::optional<HandRecording> recording_;
    bool begun_ = false;
    // The number of the next record, if none is lost.
    std::uint64_t number_ = 0;
    std::uint64_t step_ = 0;  // the step that was due after the last record
    TimePoint time_ = scene_start;
    bool incomplete_ = false;  // the recording ends where a record was lost
};

}  // namespace afferent
