// The first message of every peer: before it a listener hands over no link.
#pragma once

#include "afferent/io/wire/handshake.hpp"
#include "afferent/io/wire/message_types.hpp"

namespace afferent {

inline proto::Hello hello_of_nine() {
    proto::Hello hello;
    describe(PacketLayout{.addresses = 9}, hello);
    hello.set_scene_fingerprint(0x1234);
    hello.set_freeze_ms(60);
    hello.set_safe_ms(150);
    return hello;
}

inline proto::Envelope hello_message() {
    proto::Envelope message;
    *message.mutable_hello() = hello_of_nine();
    return message;
}

}  // namespace afferent
