// Anybody's datagrams, among those of two ends that share a key: nothing but what the other end sent is let
// in, as it was sent, once, and in order; and nobody without the key is answered. Without a key nothing
// breaks.
#include <algorithm>
#include <vector>

#include "afferent/io/links/datagram_handshake.hpp"
#include "fuzz.hpp"

namespace afferent {
namespace {

using Bytes = std::vector<std::byte>;
using Unwrapped = DatagramCodec::Unwrapped;

Bytes copy(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

// What comes from the input is no handshake's answer: its nonces and tags are of another session.
class Session {
  public:
    void run(FuzzInput& input) {
        // What opened the session, sent again, opens nothing.
        must(!initiator_.answered_by(first_) && !responder_.accept(first_, {}));
        must(listener_.receive(first_) == Unwrapped::repeated);
        while (!input.empty()) step(input);
    }

  private:
    struct Sent {
        Bytes frame;
        Bytes datagram;
        std::size_t number;  // counted from 1 in each direction
        bool by_connector;
    };

    // One end, and what it should have let in.
    struct End {
        Unwrapped receive(std::span<const std::byte> datagram) { return codec.unwrap(datagram, frame); }

        DatagramCodec codec;
        Bytes frame{};
        std::size_t sent = 0;
        std::size_t newest = 0;
    };

    static SecretKey key() {
        std::array<unsigned char, SecretKey::size> bytes{1, 2, 3};
        return SecretKey(bytes);
    }

    DatagramCodec first_entry() {
        connector_.codec.wrap({}, first_);
        ++connector_.sent;
        auto entry = responder_.accept(first_, {});
        must(entry && entry->frame.empty());
        return std::move(entry->codec);
    }

    void step(FuzzInput& input) {
        const std::uint8_t choice = input.byte();
        switch (choice % 4) {
            case 0:
                return send((choice & 4) != 0 ? connector_ : listener_, input.bytes(input.byte()));
            case 1:
                return deliver(input.byte());
            case 2:
                return forge(input.byte(), input.byte(), input.byte());
            default:
                return stray(input.bytes(input.byte()));
        }
    }

    void send(End& from, std::span<const std::byte> frame) {
        Sent sent{.frame = copy(frame),
                  .datagram = {},
                  .number = ++from.sent,
                  .by_connector = &from == &connector_};
        from.codec.wrap(frame, sent.datagram);
        must(sent.datagram.size() <= frame.size() + 27);
        sent_.push_back(std::move(sent));
    }

    void deliver(std::size_t which) {
        if (which >= sent_.size()) return;
        const Sent& sent = sent_[which];
        End& other = sent.by_connector ? listener_ : connector_;
        End& own = sent.by_connector ? connector_ : listener_;
        must(own.receive(sent.datagram) == Unwrapped::forged);
        const bool is_new = sent.number > other.newest;
        must(other.receive(sent.datagram) == (is_new ? Unwrapped::good : Unwrapped::repeated));
        if (!is_new) return;
        must(other.frame == sent.frame);
        other.newest = sent.number;
    }

    // Sent by one of the ends, and then changed, cut short or made longer.
    void forge(std::size_t which, std::size_t place, std::uint8_t change) {
        if (which >= sent_.size()) return;
        Bytes datagram = sent_[which].datagram;
        if (place >= datagram.size())
            datagram.push_back(std::byte{change});
        else if (change == 0)
            datagram.resize(place);
        else
            datagram[place] ^= std::byte{change};
        stray(datagram);
    }

    void stray(std::span<const std::byte> datagram) {
        must(connector_.receive(datagram) == Unwrapped::forged);
        must(listener_.receive(datagram) == Unwrapped::forged);
        must(!responder_.reply(datagram, {}) && !responder_.accept(datagram, {}) &&
             !initiator_.answered_by(datagram));
    }

    Responder responder_{key()};
    Initiator initiator_{key()};
    Bytes reply_{responder_.reply(initiator_.request(), {}).value()};
    Bytes first_;
    End connector_{.codec = initiator_.answered_by(reply_).value()};
    End listener_{.codec = first_entry(), .newest = 1};
    std::vector<Sent> sent_;
};

// Without a key everything that has the form is believed.
void run_plain(std::span<const std::byte> datagram) {
    Responder responder(std::nullopt);
    const Initiator initiator(std::nullopt);
    const auto is = [&](DatagramKind kind) {
        return datagram.size() == 1 && datagram[0] == std::byte(static_cast<unsigned char>(kind));
    };
    must(responder.reply(datagram, {}).has_value() == is(DatagramKind::request));
    must(initiator.answered_by(datagram).has_value() == is(DatagramKind::reply));
    if (const auto entry = responder.accept(datagram, {}))
        must(entry->frame == copy(datagram) && !entry->codec.sealed());
    DatagramCodec codec;
    Bytes frame;
    must(codec.unwrap(datagram, frame) == Unwrapped::good);
    must(datagram.size() == 1 ? frame.empty() : frame == copy(datagram));
}

}  // namespace
}  // namespace afferent

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    FuzzInput input(data, size);
    if (input.byte() % 4 == 0)
        run_plain(input.rest());
    else
        Session().run(input);
    return 0;
}
