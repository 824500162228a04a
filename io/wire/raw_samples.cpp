#include "afferent/io/wire/raw_samples.hpp"

#include <string>

#include "afferent/io/wire/frame.hpp"
#include "afferent/proto/aer.pb.h"

namespace afferent {

std::size_t raw_sample_bytes(std::size_t samples, unsigned bits) {
    proto::Envelope packet;
    packet.set_position(1000);  // two bytes, as most positions take
    packet.set_payload(std::string((samples * bits + 7) / 8, '\0'));
    return FrameWriter().stream_frame(packet).size();
}

}  // namespace afferent
