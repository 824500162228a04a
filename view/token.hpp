// The secret in the address of a view: only who is told the address can see the page.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "afferent/runtime/result.hpp"

namespace afferent {

// 128 random bits, as 32 hexadecimal digits.
std::string random_token();

// Takes as long for every guess of the right length.
bool same_token(std::string_view token, std::string_view guess) noexcept;

// The token of this file, which only this user can read or write. A file that is not so, or holds something
// else, is replaced by a new token's; one that is absent is made.
Result<std::string> kept_token(const std::filesystem::path& file);

}  // namespace afferent
