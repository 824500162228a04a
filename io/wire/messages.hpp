// Declares the messages of the wire, for headers that only pass them on. Their definitions are generated:
// io/wire/message_types.hpp.
#pragma once

namespace google::protobuf {

class MessageLite;

}  // namespace google::protobuf

namespace afferent::proto {

class Acknowledgement;
class Envelope;
class ChipHello;
class Hello;
class Readings;

}  // namespace afferent::proto
