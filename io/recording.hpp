// A session in a file: its frames as they were on the wire, readable to the last whole one after a kill.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "afferent/io/frame.hpp"
#include "afferent/io/result.hpp"
#include "afferent/proto/aer.pb.h"

namespace afferent {

// A mark, the hello, then packets and the last bye, each a frame of a stream; at the end, once it is closed,
// where the packets of each second begin, and where that index is. (recording.proto)
class RecordingWriter {
  public:
    // The hello says how the packets are to be read.
    static Result<RecordingWriter> create(const std::filesystem::path& file, const proto::Hello& hello);

    // Packets in their order, and the bye. The first error stands, and close() gives it: a full disk must not
    // stop a hand.
    void write(const proto::Envelope& message);
    Result<void> close();

  private:
    struct Close {
        void operator()(std::FILE* file) const noexcept { std::fclose(file); }
    };

    RecordingWriter(std::string name, std::FILE* file) : name_(std::move(name)), file_(file) {}
    void put(std::span<const std::byte> bytes);

    std::string name_;
    std::unique_ptr<std::FILE, Close> file_;
    bool failed_ = false;
    FrameWriter frames_;
    std::uint64_t offset_ = 0;
    std::uint64_t messages_ = 0;
    std::vector<std::uint64_t> index_;
};

class RecordingReader {
  public:
    // `malformed` where it is no recording, or has no hello.
    static Result<RecordingReader> open(const std::filesystem::path& file);

    const proto::Hello& hello() const noexcept { return hello_; }
    // Whether it was closed, and so has everything that was recorded.
    bool closed() const noexcept { return index_begin_ > 0; }

    // True: `message` is the next one. False: there is no further one that is whole.
    Result<bool> next(proto::Envelope& message);

  private:
    explicit RecordingReader(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}

    std::vector<std::byte> bytes_;
    std::uint64_t index_begin_ = 0;  // 0: there is none
    std::size_t at_ = 0;
    std::unique_ptr<FrameReader> frames_ = std::make_unique<FrameReader>();
    proto::Hello hello_;
};

}  // namespace afferent
