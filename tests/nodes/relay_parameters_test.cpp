#include "afferent/nodes/relay_parameters.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/payload.hpp"
#include "afferent/proto/aer.pb.h"

namespace afferent {
namespace {

Plan plan_of(const std::string& channel, const std::string& link = "tcp {}") {
    return make_plan(Scene::from_text("duration_s: 3 source { simulated_hand {} } link { " + link +
                                      " channel { " + channel + " } }"));
}

proto::Envelope packet_of(const Plan& plan, std::span<const Code> codes) {
    proto::Envelope packet;
    packet.set_position(1);
    PayloadCodec(*plan.packets).encode(codes, *packet.mutable_payload());
    return packet;
}

constexpr std::array<Code, 3> three_codes{1, 5, 9};

TEST(RelayParameters, OnlyDelayWhatTheHandSends) {
    const Plan plan = plan_of("latency_ms: 4 loss: 0.1 reorder: 0.2 duplicate: 0.3 corrupt: 0.4");
    const auto parameters = relay_parameters(plan, TcpAddress{}, false);
    ASSERT_TRUE(parameters) << parameters.error().text;
    EXPECT_EQ(parameters.value().to_hand.loss, 0.1);
    const ChannelParameters& back = parameters.value().to_coprocessor;
    EXPECT_EQ(back.latency, Duration(4ms));
    for (const double change : {back.loss, back.reorder, back.duplicate, back.corrupt}) EXPECT_EQ(change, 0);
}

TEST(RelayParameters, LoseAndChangeBothWaysWhereThatIsWanted) {
    const Plan plan = plan_of("loss: 0.1 reorder: 0.2 duplicate: 0.3 corrupt: 0.4");
    const auto parameters = relay_parameters(plan, TcpAddress{}, true);
    ASSERT_TRUE(parameters) << parameters.error().text;
    const ChannelParameters& back = parameters.value().to_coprocessor;
    EXPECT_EQ(back.loss, 0.1);
    EXPECT_EQ(back.reorder, 0.2);
    EXPECT_EQ(back.duplicate, 0.3);
    EXPECT_EQ(back.corrupt, 0.4);
}

TEST(RelayParameters, CountNoEventsWhereNothingIsLimitedByThem) {
    const auto parameters = relay_parameters(plan_of("loss: 0.1"), TcpAddress{}, true);
    ASSERT_TRUE(parameters) << parameters.error().text;
    EXPECT_FALSE(parameters.value().events);
}

TEST(RelayParameters, CountTheEventsOfStreamFramesAndOfDatagrams) {
    const Plan plan = plan_of("fifo_events: 10");
    FrameWriter writer;
    const auto stream = relay_parameters(plan, TcpAddress{}, true);
    ASSERT_TRUE(stream) << stream.error().text;
    EXPECT_EQ(stream.value().to_hand.fifo_events, 10U);
    EXPECT_EQ(stream.value().to_coprocessor.fifo_events, 0U);
    const auto& in_stream = stream.value().events;
    EXPECT_EQ(in_stream(writer.stream_frame(packet_of(plan, three_codes))), 3U);
    EXPECT_EQ(in_stream(writer.stream_frame(packet_of(plan, {}))), 0U);

    const auto datagrams = relay_parameters(plan, UdpAddress{}, true);
    ASSERT_TRUE(datagrams) << datagrams.error().text;
    EXPECT_EQ(datagrams.value().events(writer.datagram(packet_of(plan, three_codes))), 3U);
}

TEST(RelayParameters, CountAFrameThatCannotBeReadAsEmpty) {
    const Plan plan = plan_of("fifo_events: 10");
    const auto parameters = relay_parameters(plan, TcpAddress{}, true);
    ASSERT_TRUE(parameters) << parameters.error().text;
    const auto& events = parameters.value().events;
    FrameWriter writer;
    const auto frame = writer.stream_frame(packet_of(plan, three_codes));
    for (std::size_t size = 0; size < frame.size(); ++size) EXPECT_EQ(events(frame.first(size)), 0U) << size;
    // The frames before do not count.
    EXPECT_EQ(events(frame), 3U);
    std::vector<std::byte> changed(frame.begin(), frame.end());
    changed.back() ^= std::byte{1};
    EXPECT_EQ(events(changed), 0U);
}

TEST(RelayParameters, RefuseToCountEventsThatKeysHide) {
    Plan plan = plan_of("fifo_events: 10");
    plan.scene.file = "sealed.txtpb";
    plan.scene.link.keys = "keys";
    const auto parameters = relay_parameters(plan, TcpAddress{}, true);
    ASSERT_FALSE(parameters);
    EXPECT_EQ(parameters.error().kind, Error::Kind::not_allowed);
    EXPECT_EQ(parameters.error().text,
              "sealed.txtpb: fifo_events counts events, and those of a link with keys cannot be read");
}

}  // namespace
}  // namespace afferent
