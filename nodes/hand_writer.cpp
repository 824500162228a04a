#include "afferent/nodes/hand_writer.hpp"

namespace afferent {

void HandWriter::write(const HandRecord& record) {
    notice_losses(record.number);
    number_ = record.number + 1;
    if (!incomplete_) step_ = record.step;
    if (recording_ && !incomplete_) this->record(record);
    switch (record.kind) {
        case HandRecord::Kind::begin:
            if (record.new_hand && std::exchange(begun_, true)) observer_.starting_over();
            break;
        case HandRecord::Kind::grip_state:
            if (record.state == GripState::safe && !record.first) observer_.safe(text(record.cause));
            break;
        case HandRecord::Kind::step:
            if (!incomplete_) time_ = record.done.time;
            outputs_.take(record.done);
            observer_.step(record.done);
            break;
        default:
            break;
    }
}

void HandWriter::record(const HandRecord& record) {
    const std::optional<std::uint64_t> late_at = record.late ? std::optional(record.step) : std::nullopt;
    switch (record.kind) {
        case HandRecord::Kind::hello:
            return recording_->hello(record.message.hello(), record.step);
        case HandRecord::Kind::begin:
            return recording_->begin(record.time, record.new_hand, record.step);
        case HandRecord::Kind::packet:
            return recording_->packet(record);
        case HandRecord::Kind::bye:
            return recording_->bye(record.message.bye(), late_at);
        case HandRecord::Kind::grip_state:
            return recording_->grip_state(record.state, text(record.cause), record.step);
        case HandRecord::Kind::step:
            return recording_->step(record);
    }
}

// A recording with a hole would give another result when replayed: it ends there.
void HandWriter::notice_losses(std::uint64_t number) {
    if (number != number_) incomplete_ = true;
}

Result<void> HandWriter::close(const HandRecords& records, TimePoint time) {
    notice_losses(records.made());
    const Result<void> written = outputs_.close();
    if (recording_) {
        AFFERENT_TRY(recording_->close(incomplete_ ? time_ : time, step_));
    }
    return written;
}

}  // namespace afferent
