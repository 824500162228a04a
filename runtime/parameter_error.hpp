// The exception of constructors for an invalid parameter. Included by programs that catch it.
#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

namespace afferent {

// Names the field (as in the scene: `tau_m_ms`), the rule and the value.
class ParameterError : public std::invalid_argument {
  public:
    ParameterError(std::string field, const std::string& rule, const std::string& value)
        : std::invalid_argument(field + " must be " + rule + ", is " + value), field_(std::move(field)) {}
    ParameterError(std::string field, const std::string& rule, double value);

    const std::string& field() const noexcept { return field_; }

  private:
    std::string field_;
};

// Throws unless the value is finite and the rule holds. NaN and infinity fail every rule.
//
//     require(tau_m_ms > 0, "tau_m_ms", "> 0", tau_m_ms);
inline void require(bool holds, const char* field, const char* rule, double value) {
    if (!holds || !std::isfinite(value)) throw ParameterError(field, rule, value);
}

}  // namespace afferent
