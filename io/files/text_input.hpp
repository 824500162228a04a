// A file of text, as it is or compressed with gzip.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "afferent/runtime/result.hpp"

namespace afferent {

class TextInput {
  public:
    // A few kilobytes may decompress to any number of rows: more than this is refused.
    static constexpr std::uint64_t most_decompressed_bytes = std::uint64_t{4} << 30U;

    static Result<TextInput> open(const std::filesystem::path& file);

    // Fills the buffer, or what of it there is; 0 at the end.
    Result<std::size_t> read(std::span<char> buffer);
    // Of the file, how much has been read; 0 for a pipe.
    double fraction() const;
    // Known once something has been read.
    bool compressed() const noexcept { return compressed_; }

  private:
    struct Close {
        void operator()(void* file) const noexcept;
    };

    std::filesystem::path path_;
    std::unique_ptr<void, Close> file_;
    std::uint64_t bytes_ = 0;
    std::uint64_t file_bytes_ = 0;  // 0: it is no regular file
    bool compressed_ = false;
};

}  // namespace afferent
