// Feedback by events that cross the link in packets.
#pragma once

#include <vector>

#include "afferent/io/links/packet_intake.hpp"
#include "afferent/io/links/packet_order.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/studies/trial/feedback.hpp"

namespace afferent {

// The wire of the product: packetizer, frames, packets that wait for those they have overtaken, and a
// receiver that tells gaps and refuses what is stale. Who derives says which events there are, and what is
// done with them.
class PacketFeedback : public Feedback {
  public:
    void begin(std::uint32_t presentation) override;
    void close(TimePoint deadline, Channel& channel) override;
    bool arrive(std::span<const std::byte> frame, TimePoint arrived) override;
    std::optional<TimePoint> next_act() const override;
    void act() override;

  protected:
    PacketFeedback(const Plan& plan, const PacketLayout& layout);

    // All events before the deadline that were not given before; valid until the next call.
    virtual std::span<const Event> events_before(TimePoint deadline) = 0;
    // Takes what a packet told, which acts now.
    virtual void take(const Reception& reception) = 0;

    const Plan& plan_;

  private:
    struct Waiting {
        TimePoint acts;
        KeptReception reception;
    };

    void take_acknowledgements(TimePoint until);
    // Whether the packet measured something.
    bool receive(const proto::Envelope& packet, TimePoint arrived, TimePoint now);
    void receive_held(TimePoint now);
    Reception without_times(Waiting& waiting);
    std::optional<TimePoint> wait_ends() const;

    PacketLayout layout_;
    std::optional<Packetizer> packetizer_;
    std::optional<PacketIntake> intake_;
    std::optional<Channel> way_back_;  // of what acknowledges packets
    proto::Envelope answer_;
    PacketOrder order_;
    FrameWriter frames_;
    proto::Envelope received_;
    FrameCounts counts_;
    // What has arrived and not acted yet, in a ring.
    std::vector<Waiting> waiting_;
    std::size_t first_ = 0;
    std::size_t count_ = 0;
    // What has acted until then, where events have no times of their own.
    TimePoint acted_until_ = scene_start;
};

}  // namespace afferent
