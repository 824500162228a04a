// What a link would carry if it carried samples in place of events.
#pragma once

#include <cstddef>

namespace afferent {

// A stream's frame with so many samples, packed at the converter's resolution.
std::size_t raw_sample_bytes(std::size_t samples, unsigned bits);

}  // namespace afferent
