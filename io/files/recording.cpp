#include "afferent/io/files/recording.hpp"

#include <algorithm>
#include <array>
#include <boost/endian/conversion.hpp>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "afferent/io/files/input_file.hpp"

namespace afferent {
namespace {

constexpr std::string_view begin_mark{"afferent\x02\r\n\x1a", 12};
constexpr std::string_view end_mark = "AFFERENT";
constexpr std::size_t tail_bytes = 8 + end_mark.size();
// How much of the scene one head holds: well below the longest message.
constexpr std::size_t head_bytes = std::size_t{128} * 1024;
constexpr std::size_t marks_per_entry = 5000;

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

Error failure(const std::string& name, const std::string& what) {
    return {Error::Kind::closed, name + ": " + what};
}

// Whether the file is neither empty nor a recording: a scene or a table, given by mistake.
bool is_something_else(const std::filesystem::path& file) {
    std::error_code none;
    if (!std::filesystem::is_regular_file(file, none) || std::filesystem::file_size(file, none) == 0)
        return false;
    const FileHandle in(std::fopen(file.c_str(), "rbe"));
    std::array<char, begin_mark.size()> begin{};
    const std::size_t count = in ? std::fread(begin.data(), 1, begin.size(), in.get()) : 0;
    return count == 0 || !begin_mark.starts_with(std::string_view(begin.data(), count));
}

std::uint64_t frame_bytes(std::size_t message) {
    return message + 4 + (message < (1U << 7) ? 1 : message < (1U << 14) ? 2 : 3);
}

}  // namespace

Result<RecordingWriter> RecordingWriter::create(const std::filesystem::path& file,
                                                proto::RecordingHead head) {
    if (head.scene().size() > most_recorded_scene)
        return Error{Error::Kind::malformed, file.string() + ": the scene's text has " +
                                                 std::to_string(head.scene().size()) +
                                                 " bytes, a recording holds 2^20"};
    if (is_something_else(file))
        return Error{
            Error::Kind::not_allowed,
            file.string() + ": exists and is not a recording, so it is not overwritten; choose another name"};
    std::FILE* opened = std::fopen(file.c_str(), "wbe");
    if (opened == nullptr)
        return failure(file.string(), std::string("cannot be written: ") + std::strerror(errno));
    RecordingWriter writer(file.string(), opened);
    std::setvbuf(opened, nullptr, _IONBF, 0);
    writer.put(bytes_of(begin_mark));
    const std::string scene = std::move(*head.mutable_scene());
    for (std::size_t at = 0; at == 0 || at < scene.size(); at += head_bytes) {
        head.set_scene(scene.substr(at, head_bytes));
        head.set_more(at + head_bytes < scene.size());
        proto::Entry entry;
        *entry.mutable_head() = head;
        writer.write(entry);
        head.Clear();
    }
    return writer;
}

void RecordingWriter::write(const proto::Entry& entry) {
    if (entry.has_mark()) marks_.push_back({scene_start + Duration(entry.mark().time_ns()), offset_});
    put(frames_.stream_frame(entry));
}

Result<void> RecordingWriter::close() {
    const std::uint64_t index = offset_;
    for (std::size_t i = 0; i == 0 || i < marks_.size();) {
        proto::Entry part;
        part.mutable_index();
        for (const std::size_t end = std::min(i + marks_per_entry, marks_.size()); i < end; ++i) {
            part.mutable_index()->add_time_ns((marks_[i].time - scene_start).count());
            part.mutable_index()->add_offset(marks_[i].offset);
        }
        write(part);
        if (marks_.empty()) break;
    }
    std::array<unsigned char, 8> where;
    boost::endian::store_little_u64(where.data(), index);
    put(std::as_bytes(std::span(where)));
    put(bytes_of(end_mark));
    file_.reset();
    if (failed_ != 0)
        return failure(name_, std::string("cannot be written to its end: ") + std::strerror(failed_));
    return success();
}

void RecordingWriter::put(std::span<const std::byte> bytes) {
    if (failed_ != 0) return;
    if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) failed_ = errno;
    offset_ += bytes.size();
}

Result<RecordingReader> RecordingReader::open(const std::filesystem::path& file) {
    AFFERENT_TRY(opened, open_input(file));
    RecordingReader reader(file.string(), opened.release());
    AFFERENT_TRY(reader.find_end());
    AFFERENT_TRY(reader.read_head());
    return reader;
}

Error RecordingReader::malformed(const std::string& what) const {
    return {Error::Kind::malformed, name_ + ": " + what};
}

Result<void> RecordingReader::find_end() {
    std::array<char, begin_mark.size()> begin;
    if (std::fread(begin.data(), 1, begin.size(), file_.get()) != begin.size() ||
        std::string_view(begin.data(), begin.size()) != begin_mark)
        return malformed("is not a recording");
    if (fseeko(file_.get(), 0, SEEK_END) != 0) return failure(name_, std::strerror(errno));
    end_ = static_cast<std::uint64_t>(ftello(file_.get()));
    std::array<char, tail_bytes> tail;
    if (end_ >= begin.size() + tail.size()) {
        fseeko(file_.get(), -static_cast<off_t>(tail.size()), SEEK_END);
        if (std::fread(tail.data(), 1, tail.size(), file_.get()) != tail.size())
            return failure(name_, "cannot be read");
        const std::uint64_t index =
            boost::endian::load_little_u64(reinterpret_cast<const unsigned char*>(tail.data()));
        if (std::string_view(tail.data() + 8, end_mark.size()) == end_mark && index >= begin.size() &&
            index < end_ - tail.size()) {
            index_ = index;
            end_ -= tail.size();
        }
    }
    return seek(begin.size());
}

Result<void> RecordingReader::read_head() {
    bool more = true;
    for (std::string scene; more;) {
        proto::Entry entry;
        AFFERENT_TRY(read, next(entry));
        if (!read || !entry.has_head()) return malformed("has no head, or an incomplete one");
        scene += entry.head().scene();
        if (scene.size() > most_recorded_scene) return malformed("its scene is too long");
        more = entry.head().more();
        // A head without text would make this loop as long as the file.
        if (more && entry.head().scene().empty()) return malformed("a head is empty");
        if (head_.scene().empty()) head_ = entry.head();
        head_.set_scene(scene);
    }
    return success();
}

Result<void> RecordingReader::seek(std::uint64_t offset) {
    if (fseeko(file_.get(), static_cast<off_t>(offset), SEEK_SET) != 0)
        return failure(name_, std::strerror(errno));
    frames_ = std::make_unique<FrameReader>();
    given_ = next_ = offset;
    return success();
}

Result<bool> RecordingReader::next(proto::Entry& entry) {
    const Result<bool> read = this->read(entry);
    if (read && read.value() && entry.has_index()) return false;
    return read;
}

Result<bool> RecordingReader::read(proto::Entry& entry) {
    for (;;) {
        std::span<const std::byte> message;
        const Result<bool> read = frames_->next_bytes(message);
        const auto wrong = [&](const std::string& text) {
            return malformed("the entry at byte " + std::to_string(next_) + ": " + text);
        };
        if (!read) return wrong(read.error().text);
        if (read.value()) {
            if (!entry.ParseFromArray(message.data(), static_cast<int>(message.size())))
                return wrong("cannot be read");
            next_ += frame_bytes(message.size());
            return true;
        }
        const auto space = frames_->space();
        const std::size_t wanted = std::min<std::uint64_t>(space.size(), end_ - given_);
        const std::size_t count = std::fread(space.data(), 1, wanted, file_.get());
        if (count < wanted) return failure(name_, "cannot be read to its end");
        if (count == 0 && closed() && next_ != end_) return wrong("is cut off");
        if (count == 0) return false;
        frames_->filled(count);
        given_ += count;
    }
}

// Times before the start are refused, so that subtracting from a mark cannot overflow.
Result<void> RecordingReader::add_mark(std::int64_t time_ns, std::uint64_t offset,
                                       std::vector<RecordedMark>& marks) const {
    if (time_ns < 0) return malformed("a mark has a negative time");
    marks.push_back({scene_start + Duration(time_ns), offset});
    return success();
}

Result<std::vector<RecordedMark>> RecordingReader::marks() {
    std::vector<RecordedMark> marks;
    const std::uint64_t before = next_;
    AFFERENT_TRY(closed() ? read_index(marks) : find_marks(marks));
    AFFERENT_TRY(seek(before));
    return marks;
}

Result<void> RecordingReader::find_marks(std::vector<RecordedMark>& marks) {
    AFFERENT_TRY(seek(begin_mark.size()));
    for (proto::Entry entry;;) {
        const std::uint64_t offset = next_;
        AFFERENT_TRY(read, next(entry));
        if (!read) return success();
        if (!entry.has_mark()) continue;
        AFFERENT_TRY(add_mark(entry.mark().time_ns(), offset, marks));
    }
}

Result<void> RecordingReader::read_index(std::vector<RecordedMark>& marks) {
    AFFERENT_TRY(seek(index_));
    for (proto::Entry entry; next_ < end_;) {
        AFFERENT_TRY(read(entry));
        const proto::RecordingIndex& index = entry.index();
        if (!entry.has_index() || index.time_ns_size() != index.offset_size())
            return malformed("its index cannot be read");
        for (int i = 0; i < index.offset_size(); ++i) {
            AFFERENT_TRY(add_mark(index.time_ns(i), index.offset(i), marks));
        }
    }
    return success();
}

Result<void> RecordingReader::go_to(const RecordedMark& mark) {
    if (mark.offset < begin_mark.size() || mark.offset >= end_)
        return malformed("its index points outside of the file");
    AFFERENT_TRY(seek(mark.offset));
    proto::Entry entry;
    AFFERENT_TRY(read, this->read(entry));
    if (!read || !entry.has_mark() || scene_start + Duration(entry.mark().time_ns()) != mark.time)
        return malformed("its index points to something else than a mark");
    return seek(mark.offset);
}

double RecordingReader::fraction() const noexcept {
    return static_cast<double>(next_) / static_cast<double>(std::max<std::uint64_t>(end_, 1));
}

}  // namespace afferent
