// Turns text in UTF-16, as spreadsheets and acquisition programs save it, into UTF-8.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace afferent {

// Text begins in UTF-16 if it begins with that mark of byte order, or if one of its first two bytes is 0.
bool begins_in_utf16(std::string_view first_two_bytes) noexcept;

class Utf16Text {
  public:
    // Throws std::bad_alloc. `first_two_bytes` tell the order of bytes.
    explicit Utf16Text(std::string_view first_two_bytes);

    // The next bytes as UTF-8, valid until the next call. A character that is cut off waits for its end.
    // Empty optional: these bytes are no UTF-16.
    std::optional<std::string_view> decode(std::string_view bytes);

  private:
    struct Close {
        void operator()(void* converter) const noexcept;
    };
    std::unique_ptr<void, Close> converter_;
    std::string begun_;  // a character whose end has not come yet
    std::string text_;
};

}  // namespace afferent
