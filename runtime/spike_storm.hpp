// The error that ends a run in which a neuron fires more often than the scene allows.
#pragma once

#include <stdexcept>
#include <string>

#include "afferent/runtime/event.hpp"

namespace afferent {

class SpikeStormError : public std::runtime_error {
  public:
    SpikeStormError(Address address, TimePoint time, const std::string& parameters)
        : std::runtime_error("address " + std::to_string(address) +
                             " fires more often than the scene's limit at " + std::to_string(seconds(time)) +
                             " s (" + parameters + ")"),
          address_(address),
          time_(time) {}

    Address address() const noexcept { return address_; }
    TimePoint time() const noexcept { return time_; }

  private:
    Address address_;
    TimePoint time_;
};

}  // namespace afferent
