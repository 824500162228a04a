// Recordings as files: entries in the order in which things happened. After a kill a file can be read up to
// its last complete entry.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "afferent/io/wire/frame.hpp"
#include "afferent/proto/recording.pb.h"
#include "afferent/runtime/result.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// The longest text of a scene that a recording holds.
inline constexpr std::size_t most_recorded_scene = std::size_t{1} << 20;

struct CloseFile {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, CloseFile>;

// The place of a mark in the file.
struct RecordedMark {
    TimePoint time;
    std::uint64_t offset;
};

// Each entry is passed to the operating system, in one call, before write() returns: a process that is killed
// loses at most the current entry. If the machine fails, what the system has not written yet is lost, some
// seconds of it.
class RecordingWriter {
  public:
    // Writes the head, in as many entries as its scene takes. `malformed` if the scene is too long,
    // `not_allowed` if the file exists and is not a recording: it is not overwritten.
    static Result<RecordingWriter> create(const std::filesystem::path& file, proto::RecordingHead head);

    // After the first error nothing more is written, and close() returns that error: a full disk must not
    // stop a hand.
    void write(const proto::Entry& entry);
    // With the index.
    Result<void> close();

  private:
    RecordingWriter(std::string name, std::FILE* file) : name_(std::move(name)), file_(file) {}
    void put(std::span<const std::byte> bytes);

    std::string name_;
    FileHandle file_;
    int failed_ = 0;  // errno
    FrameWriter frames_;
    std::uint64_t offset_ = 0;
    std::vector<RecordedMark> marks_;
};

// Reads entry by entry: memory does not grow with the file.
class RecordingReader {
  public:
    // `malformed` if it is not a recording, or has no head.
    static Result<RecordingReader> open(const std::filesystem::path& file);

    // With the whole scene.
    const proto::RecordingHead& head() const noexcept { return head_; }
    // True if it was closed, and so has everything that was recorded.
    bool closed() const noexcept { return index_ > 0; }

    // True: `entry` is the next entry. False: there is no further complete entry.
    Result<bool> next(proto::Entry& entry);

    // All marks in the order of the file: from the index, or by reading to the end if there is none. The next
    // entry stays the same.
    Result<std::vector<RecordedMark>> marks();
    // Makes this mark the next entry to be read.
    Result<void> go_to(const RecordedMark& mark);

    // How much has been read, 0 to 1.
    double fraction() const noexcept;

  private:
    RecordingReader(std::string name, std::FILE* file) : name_(std::move(name)), file_(file) {}
    Error malformed(const std::string& what) const;
    Result<void> add_mark(std::int64_t time_ns, std::uint64_t offset, std::vector<RecordedMark>& marks) const;
    Result<void> find_end();
    Result<void> read_head();
    Result<void> seek(std::uint64_t offset);
    Result<void> find_marks(std::vector<RecordedMark>& marks);
    Result<bool> read(proto::Entry& entry);
    Result<void> read_index(std::vector<RecordedMark>& marks);

    std::string name_;
    FileHandle file_;
    std::uint64_t end_ = 0;    // of all entries
    std::uint64_t index_ = 0;  // where its entries begin; 0: there is none
    std::uint64_t given_ = 0;  // frames_ has the file up to here
    std::uint64_t next_ = 0;   // where the next entry begins
    std::unique_ptr<FrameReader> frames_;
    proto::RecordingHead head_;
};

}  // namespace afferent
