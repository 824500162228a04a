// A hello of any content is refused in words, or describes a layout that can be built.
#include "afferent/io/wire/handshake.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/proto/aer.pb.h"
#include "fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    proto::Hello hello;
    if (!hello.ParseFromArray(data, static_cast<int>(size))) return 0;
    proto::Hello ours;
    describe(PacketLayout{.addresses = 9}, ours);
    if (const auto difference = disagreement(hello, ours)) must(!difference->empty());
    must(!disagreement(hello, hello) || hello.SerializeAsString() != ours.SerializeAsString());
    const Result<PacketLayout> layout = layout_of(hello);
    if (!layout) {
        must(!layout.error().text.empty());
        return 0;
    }
    layout.value().check();
    proto::Hello again = hello;
    describe(layout.value(), again);
    must(layout_of(again) && layout_of(again).value() == layout.value());
    return 0;
}
