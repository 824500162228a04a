#include "afferent/runtime/parameter_error.hpp"

#include <charconv>
#include <utility>

namespace afferent {
namespace {

std::string shortest(double value) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    return {text, end};
}

}  // namespace

ParameterError::ParameterError(std::string field, const std::string& rule, double value)
    : ParameterError(std::move(field), rule, shortest(value)) {}

}  // namespace afferent
