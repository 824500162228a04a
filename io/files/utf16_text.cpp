#include "afferent/io/files/utf16_text.hpp"

#include <iconv.h>

#include <cerrno>
#include <cstdint>
#include <new>

namespace afferent {
namespace {

constexpr std::string_view mark = "\xFF\xFE";
constexpr std::string_view mark_of_high_byte_first = "\xFE\xFF";

// glibc's iconv has no state to be freed by anything but iconv_close(), and -1 for "none".
iconv_t open(const char* encoding) {
    const iconv_t converter = ::iconv_open("UTF-8", encoding);
    if (reinterpret_cast<std::intptr_t>(converter) == -1) throw std::bad_alloc();
    return converter;
}

}  // namespace

bool begins_in_utf16(std::string_view two) noexcept {
    return two == mark || two == mark_of_high_byte_first || (two[0] == '\0') != (two[1] == '\0');
}

void Utf16Text::Close::operator()(void* converter) const noexcept { ::iconv_close(converter); }

Utf16Text::Utf16Text(std::string_view two)
    : converter_(open(two == mark_of_high_byte_first || two[0] == '\0' ? "UTF-16BE" : "UTF-16LE")) {}

std::optional<std::string_view> Utf16Text::decode(std::string_view bytes) {
    begun_ += bytes;
    char* in = begun_.data();
    std::size_t in_left = begun_.size();
    // Two bytes become three at most, and four become four.
    text_.resize(begun_.size() + begun_.size() / 2 + 4);
    char* out = text_.data();
    std::size_t out_left = text_.size();
    const std::size_t code = ::iconv(converter_.get(), &in, &in_left, &out, &out_left);
    if (code == static_cast<std::size_t>(-1) && errno != EINVAL) return std::nullopt;
    begun_.erase(0, begun_.size() - in_left);
    return std::string_view(text_.data(), text_.size() - out_left);
}

}  // namespace afferent
