#include "afferent/io/recording.hpp"

#include <algorithm>
#include <array>
#include <boost/endian/conversion.hpp>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>

#include "afferent/proto/recording.pb.h"

namespace afferent {
namespace {

constexpr std::string_view begin_mark{"afferent\x01\r\n\x1a", 12};
constexpr std::string_view end_mark = "AFFERENT";
constexpr std::uint64_t messages_per_entry = 200;

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

Error failure(const std::string& name, const std::string& what) {
    return {Error::Kind::closed, name + ": " + what};
}

}  // namespace

Result<RecordingWriter> RecordingWriter::create(const std::filesystem::path& file,
                                                const proto::Hello& hello) {
    std::FILE* opened = std::fopen(file.c_str(), "wb");
    if (opened == nullptr) return failure(file.string(), std::strerror(errno));
    RecordingWriter writer(file.string(), opened);
    writer.put(bytes_of(begin_mark));
    proto::Envelope first;
    *first.mutable_hello() = hello;
    writer.put(writer.frames_.stream_frame(first));
    return writer;
}

void RecordingWriter::write(const proto::Envelope& message) {
    if (messages_++ % messages_per_entry == 0) {
        index_.push_back(offset_);
        // What is on its way to the file is lost in a kill: no more than a second of default packets.
        std::fflush(file_.get());
    }
    put(frames_.stream_frame(message));
}

Result<void> RecordingWriter::close() {
    proto::RecordingIndex index;
    index.mutable_offset()->Assign(index_.begin(), index_.end());
    index.set_messages(messages_);
    const std::uint64_t index_begin = offset_;
    put(bytes_of(index.SerializeAsString()));
    std::array<unsigned char, 8> where;
    boost::endian::store_little_u64(where.data(), index_begin);
    put(std::as_bytes(std::span(where)));
    put(bytes_of(end_mark));
    if (std::fflush(file_.get()) != 0) failed_ = true;
    file_.reset();
    if (failed_) return failure(name_, "cannot be written to its end");
    return success();
}

void RecordingWriter::put(std::span<const std::byte> bytes) {
    if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) failed_ = true;
    offset_ += bytes.size();
}

Result<RecordingReader> RecordingReader::open(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) return failure(file.string(), "cannot be read");
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    if (!text.starts_with(begin_mark))
        return Error{Error::Kind::malformed, file.string() + ": is no recording"};
    const auto bytes = bytes_of(text);
    RecordingReader reader({bytes.begin(), bytes.end()});
    const std::size_t tail = 8 + end_mark.size();
    if (text.size() >= begin_mark.size() + tail && text.ends_with(end_mark)) {
        const auto* where = reinterpret_cast<const unsigned char*>(text.data() + text.size() - tail);
        const std::uint64_t index_begin = boost::endian::load_little_u64(where);
        if (index_begin >= begin_mark.size() && index_begin <= text.size() - tail)
            reader.index_begin_ = index_begin;
    }
    if (reader.closed()) reader.bytes_.resize(reader.index_begin_);
    reader.at_ = begin_mark.size();
    proto::Envelope first;
    const Result<bool> read = reader.next(first);
    if (!read) return Error{Error::Kind::malformed, file.string() + ": " + read.error().text};
    if (!read.value() || !first.has_hello())
        return Error{Error::Kind::malformed, file.string() + ": has no hello"};
    reader.hello_ = first.hello();
    return reader;
}

Result<bool> RecordingReader::next(proto::Envelope& message) {
    for (;;) {
        const Result<bool> read = frames_->next(message);
        if (!read || read.value()) return read;
        if (at_ == bytes_.size()) return false;
        const auto space = frames_->space();
        const std::size_t count = std::min(space.size(), bytes_.size() - at_);
        std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), count, space.begin());
        frames_->filled(count);
        at_ += count;
    }
}

}  // namespace afferent
