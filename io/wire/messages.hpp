// Declares the messages of the wire, for headers that only pass them on. Their definitions are generated:
// io/wire/message_types.hpp.
#pragma once

namespace google::protobuf {

class MessageLite;

}  // namespace google::protobuf

namespace afferent {

namespace proto {

class Acknowledgement;
class Envelope;
class ChipHello;
class Hello;
class Readings;

}  // namespace proto

// Whether this is a packet, and not a message of the session.
bool is_packet(const proto::Envelope& message) noexcept;

}  // namespace afferent
