// Messages of a hostile or broken peer.
#pragma once

#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "afferent/io/wire/message_types.hpp"
#include "afferent/nodes/hello.hpp"
#include "tests/faults/faulty_network.hpp"

namespace afferent {

inline proto::Envelope hello_of(const Plan& plan, bool of_the_scene = true) {
    proto::Envelope message;
    *message.mutable_hello() = make_hello(plan, false);
    if (!of_the_scene) message.mutable_hello()->set_scene_fingerprint(1);
    return message;
}

inline proto::Envelope bye_message(proto::ByeReason reason, Duration at = {}) {
    proto::Envelope message;
    message.mutable_bye()->set_reason(reason);
    message.mutable_bye()->set_time_ns(at.count());
    return message;
}

inline proto::Envelope clock_message(Duration time) {
    proto::Envelope message;
    message.mutable_clock()->set_time_ns(time.count());
    return message;
}

// A message that is not a packet of the scene; nothing stands for bytes that are no message.
inline std::optional<proto::Envelope> hostile_message(std::mt19937_64& random, const Plan& plan,
                                                      const proto::Envelope& hello) {
    const auto any_time = [&] {
        switch (random() % 4) {
            case 0:
                return Duration(static_cast<Duration::rep>(random()));
            case 1:
                return plan.end() - scene_start + 1s;  // at its end the hand ends, as it should
            default:
                return Duration(static_cast<Duration::rep>(random() % 100'000'000'000));
        }
    };
    proto::Envelope message;
    switch (random() % 8) {
        case 0:
            return std::nullopt;
        case 1:
            return bye_message(static_cast<proto::ByeReason>(random() % 4), any_time());
        case 2:
            return clock_message(any_time());
        case 3:
            message = hello;
            message.mutable_hello()->set_nonce(random());
            return message;
        case 4:
            message.mutable_answer()->set_welcome(true);
            return message;
        case 5:
            message.mutable_status()->set_gain(1);
            return message;
        case 6:
            message.mutable_samples()->set_time_ns(any_time().count());
            message.mutable_samples()->add_force_n(1);
            return message;
        default:
            // With a code that no layout has.
            message.set_position(static_cast<std::uint32_t>(random() % 20'000 + 1));
            message.set_payload(std::string(40, '\xff'));
            return message;
    }
}

// An unexpected peer. It sends its messages as soon as it is accepted, and then nothing.
class Stranger {
  public:
    Stranger(FaultyNetwork& network, std::vector<proto::Envelope> messages)
        : messages_(std::move(messages)), connector_(network.connector(true)) {
        connector_->start([this](Result<std::unique_ptr<Link>> link) {
            if (!link) return;
            link_ = std::move(link).value();
            link_->start({.message = [](const auto&) {},
                          .bad_frame = [](const auto&) {},
                          .closed = [](const auto&) {}});
            for (const proto::Envelope& message : messages_) link_->send(message);
        });
    }
    void say(const proto::Envelope& message) {
        if (link_) link_->send(message);
    }

  private:
    std::vector<proto::Envelope> messages_;
    std::unique_ptr<Link> link_;
    std::unique_ptr<Connector> connector_;
};

}  // namespace afferent
