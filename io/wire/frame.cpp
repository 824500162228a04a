#include "afferent/io/wire/frame.hpp"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/unknown_field_set.h>

#include <algorithm>
#include <boost/endian/conversion.hpp>
#include <cassert>
#include <cstring>
#include <string>

#include "afferent/io/wire/checksum.hpp"
#include "afferent/proto/aer.pb.h"

namespace afferent {
namespace {

constexpr std::size_t checksum_bytes = 4;
constexpr std::size_t max_length_bytes = 3;
constexpr std::size_t first_bytes = std::size_t{4} * 1024;

unsigned char* raw(std::byte* bytes) { return reinterpret_cast<unsigned char*>(bytes); }
const unsigned char* raw(const std::byte* bytes) { return reinterpret_cast<const unsigned char*>(bytes); }

// A correct peer of our version sends no unknown field, and other versions are refused at the hello. To
// accept one here would only let a peer fill memory, or pass off a message as empty.
bool has_unknown_fields(const google::protobuf::Message& message) {
    const auto* reflection = message.GetReflection();
    if (!reflection->GetUnknownFields(message).empty()) return true;
    std::vector<const google::protobuf::FieldDescriptor*> fields;
    reflection->ListFields(message, &fields);
    for (const auto* field : fields) {
        if (field->cpp_type() != google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE) continue;
        if (field->is_repeated()) {
            for (int i = 0; i < reflection->FieldSize(message, field); ++i)
                if (has_unknown_fields(reflection->GetRepeatedMessage(message, field, i))) return true;
        } else if (has_unknown_fields(reflection->GetMessage(message, field))) {
            return true;
        }
    }
    return false;
}

bool has_packet_fields(const proto::Envelope& message) {
    return message.position() != 0 || message.spans() != 0 || message.part() != 0 || message.more() ||
           message.has_count() || message.has_begin() || !message.payload().empty();
}

Result<void> parse(std::span<const std::byte> bytes, proto::Envelope& message) {
    const auto refuse = [](const char* text) { return Error{Error::Kind::malformed, text}; };
    if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
        return refuse("a frame's message cannot be read");
    if (message.content_case() == proto::Envelope::CONTENT_NOT_SET) {
        if (!is_packet(message)) return refuse("a message is neither a packet nor anything else");
        if (!message.GetReflection()->GetUnknownFields(message).empty())
            return refuse("a packet has unknown fields");
        return success();
    }
    if (has_packet_fields(message)) return refuse("a message is a packet and something else as well");
    if (has_unknown_fields(message)) return refuse("a message has unknown fields");
    return success();
}

// How many bytes the length takes at the beginning of a complete frame.
std::size_t length_bytes(std::span<const std::byte> frame) {
    std::size_t head = 1;
    while (std::to_integer<unsigned>(frame[head - 1]) >= 0x80) ++head;
    return head;
}

// The bytes of the message, if the checksum behind them is right.
Result<std::span<const std::byte>> checked(std::span<const std::byte> bytes, FrameCounts& counts) {
    const auto body = bytes.first(bytes.size() - checksum_bytes);
    if (boost::endian::load_little_u32(raw(bytes.data() + body.size())) == crc32c(body)) return body;
    ++counts.checksum_failures;
    return Error{Error::Kind::checksum,
                 "a frame of " + std::to_string(bytes.size()) + " bytes fails its checksum"};
}

Result<void> parse(std::span<const std::byte> bytes, proto::Envelope& message, FrameCounts& counts) {
    Result<void> parsed = parse(bytes, message);
    ++(parsed ? counts.frames : counts.refused);
    return parsed;
}

}  // namespace

bool is_packet(const proto::Envelope& message) noexcept {
    return message.position() != 0 || !message.payload().empty();
}

std::optional<std::size_t> stream_frame_size(std::span<const std::byte> bytes, std::size_t longest_message) {
    std::size_t length = 0;
    for (std::size_t head = 0; head < max_length_bytes; ++head) {
        if (head == bytes.size()) return 0;
        const auto byte = std::to_integer<std::size_t>(bytes[head]);
        length |= (byte & 0x7f) << (7 * head);
        if (length > longest_message) return std::nullopt;
        if (byte < 0x80) return head + 1 + length + checksum_bytes;
    }
    return std::nullopt;
}

std::span<const std::byte> FrameWriter::stream_frame(const google::protobuf::MessageLite& message) {
    return write(message, true);
}

std::span<const std::byte> FrameWriter::datagram(const google::protobuf::MessageLite& message) {
    return write(message, false);
}

std::span<const std::byte> FrameWriter::write(const google::protobuf::MessageLite& message,
                                              bool with_length) {
    using google::protobuf::io::CodedOutputStream;
    const std::size_t size = message.ByteSizeLong();
    assert(size <= max_message_bytes);
    bytes_.resize(max_length_bytes + size + checksum_bytes);
    auto* const begin = raw(bytes_.data());
    auto* const body = with_length
                           ? CodedOutputStream::WriteVarint32ToArray(static_cast<std::uint32_t>(size), begin)
                           : begin;
    auto* const end = message.SerializeWithCachedSizesToArray(body);
    const auto* const body_bytes = reinterpret_cast<const std::byte*>(body);
    boost::endian::store_little_u32(end, crc32c({body_bytes, size}));
    return {bytes_.data(), static_cast<std::size_t>(end - begin) + checksum_bytes};
}

Result<void> read_datagram(std::span<const std::byte> datagram, proto::Envelope& message,
                           FrameCounts& counts) {
    counts.bytes += datagram.size();
    if (datagram.size() < checksum_bytes || datagram.size() > max_message_bytes + checksum_bytes) {
        ++counts.refused;
        return Error{Error::Kind::malformed,
                     "a datagram of " + std::to_string(datagram.size()) + " bytes holds no frame"};
    }
    AFFERENT_TRY(body, checked(datagram, counts));
    return parse(body, message, counts);
}

FrameReader::FrameReader(std::size_t longest_message)
    : longest_message_(longest_message), bytes_(std::min(first_bytes, longest_frame())) {
    assert(longest_message <= max_message_bytes);
}

std::size_t FrameReader::longest_frame() const noexcept {
    return max_length_bytes + longest_message_ + checksum_bytes;
}

void FrameReader::reserve() { bytes_.resize(longest_frame()); }

std::span<std::byte> FrameReader::space() {
    if (begin_ == end_) {
        begin_ = end_ = 0;
    } else if (begin_ > 0 && end_ > bytes_.size() / 2) {
        std::memmove(bytes_.data(), bytes_.data() + begin_, end_ - begin_);
        end_ -= begin_;
        begin_ = 0;
    }
    // It holds the beginning of one frame and nothing else.
    if (end_ == bytes_.size()) bytes_.resize(std::min(2 * bytes_.size(), longest_frame()));
    return std::span(bytes_).subspan(end_);
}

void FrameReader::filled(std::size_t count) noexcept {
    assert(count <= bytes_.size() - end_);
    end_ += count;
    counts_.bytes += count;
}

Result<bool> FrameReader::next(proto::Envelope& message) {
    std::span<const std::byte> body;
    const Result<bool> read = next_bytes(body);
    if (!read || !read.value()) return read;
    AFFERENT_TRY(parse(body, message, counts_));
    return true;
}

Result<bool> FrameReader::next_bytes(std::span<const std::byte>& message) {
    if (lost_) return Error{Error::Kind::malformed, "the stream has lost its frames"};
    const std::span<const std::byte> bytes = std::span(bytes_).subspan(begin_, end_ - begin_);
    const auto size = stream_frame_size(bytes, longest_message_);
    if (!size) {
        // It is not known where this frame ends, nor where the next one begins.
        lost_ = true;
        ++counts_.refused;
        return Error{Error::Kind::malformed,
                     "a frame claims more than the " + std::to_string(longest_message_) + " bytes allowed"};
    }
    if (*size == 0 || bytes.size() < *size) return false;
    begin_ += *size;
    const std::size_t head = length_bytes(bytes);
    AFFERENT_TRY(body, checked(bytes.subspan(head, *size - head), counts_));
    message = body;
    return true;
}

}  // namespace afferent
