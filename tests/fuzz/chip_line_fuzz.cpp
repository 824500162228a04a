// Anything on the line of a chip: bytes as they are, or messages of any bytes in frames with a good checksum.
// Events come in order, of afferents that there are, and none of a time that is not known.
#include "afferent/io/wire/checksum.hpp"
#include "afferent/io/wire/handshake.hpp"
#include "afferent/nodes/chip_reader.hpp"
#include "afferent/scene/chip_fingerprint.hpp"
#include "fuzz.hpp"

namespace afferent {
namespace {

const Plan& plan_of_a_chip() {
    static const Plan plan = make_plan(Scene::from_text(
        "duration_s: 60 source { chip { device: 'tty' compare: true } } link { tcp {} } hand {} "
        "patch { name: 'thumb' elements: 3 share: [0.2, 0.2, 0.1] neuron { delta_g: 0.03 fixed_point {} } "
        "}"));
    return plan;
}

std::vector<std::byte> framed(std::span<const std::byte> message) {
    std::vector<std::byte> frame(message.begin(), message.end());
    const std::uint32_t crc = crc32c(message);
    for (int i = 0; i < 4; ++i) frame.push_back(static_cast<std::byte>(crc >> (8 * i)));
    std::vector<std::byte> line;
    append_cobs(frame, line);
    return line;
}

}  // namespace
}  // namespace afferent

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    FuzzInput input(data, size);
    const Plan& plan = plan_of_a_chip();
    static Coprocessor emulator(plan);
    emulator.reset();
    ChipReader reader(plan, &emulator);
    // A chip that is believed, so that the rest is looked at.
    proto::Envelope hello;
    hello.mutable_chip()->set_version(wire_version);
    hello.mutable_chip()->set_fingerprint(*chip_fingerprint(plan));
    FrameWriter writer;
    std::vector<std::byte> known;
    append_cobs(writer.datagram(hello), known);
    reader.read(MonotonicTime(), scene_start, known);
    TimePoint now = scene_start;
    TimePoint last = scene_start;
    while (!input.empty()) {
        const std::uint8_t how = input.byte();
        now += (how % 16) * 1ms;
        const auto bytes = input.bytes(1U + how / 4);
        const auto line = how % 4 == 0 ? std::vector<std::byte>(bytes.begin(), bytes.end()) : framed(bytes);
        reader.read(MonotonicTime(now - scene_start), now, line);
        must(reader.known_until() <= now + 200ms);
        (void)reader.clock_ahead();
        const TimePoint until = how % 3 == 0 ? now : reader.known_until() - Duration(1);
        for (const Event& event : reader.take(until)) {
            must(event.address < plan.addresses);
            must(event.time >= last && event.time <= until);
            last = event.time;
        }
        (void)reader.knows(now - 25ms, now);
    }
    for (int notes = 0; reader.next_note(); ++notes) must(notes < 100);
    (void)reader.report();
    return 0;
}
