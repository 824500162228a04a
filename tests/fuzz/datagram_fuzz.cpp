// Datagrams from anybody, mixed with those of the two ends of a session: only what the other end sent is
// accepted, unchanged and once, across changes of the key. Without keys nothing breaks.
#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "afferent/io/links/datagram_codec.hpp"
#include "afferent/io/wire/frame.hpp"
#include "fuzz.hpp"

namespace afferent {
namespace {

using Bytes = std::vector<std::byte>;
using Unwrapped = DatagramCodec::Unwrapped;

Bytes copy(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

class Session {
  public:
    void run(FuzzInput& input) {
        while (!input.empty()) step(input);
    }

  private:
    struct Sent {
        Bytes frame;
        Bytes datagram;
        std::size_t number;  // counted from 1 in each direction
        std::size_t period;  // of the key, counted from 0
        bool by_connector;
    };

    // One end, and what it has let in.
    struct End {
        DatagramCodec codec;
        Bytes frame{};
        std::size_t sent = 0;
        std::size_t period = 0;  // of the last that was sent
        std::byte key{64};
        std::set<std::size_t> taken{};
        std::size_t newest = 0;
        std::size_t newest_period = 0;
    };

    static SecretKey key(unsigned char number) {
        std::array<unsigned char, SecretKey::size> bytes{1, 2, number};
        return SecretKey(bytes);
    }

    void step(FuzzInput& input) {
        const std::uint8_t choice = input.byte();
        now_ += std::chrono::milliseconds(1);
        switch (choice % 5) {
            case 0:
                return send((choice & 4) != 0 ? connector_ : listener_, input.bytes(input.byte()));
            case 1:
                return deliver(input.byte());
            case 2:
                return forge(input.byte(), input.byte(), input.byte());
            case 3:
                now_ += std::chrono::seconds(input.byte());
                return;
            default:
                return stray(input.bytes(input.byte()));
        }
    }

    void send(End& from, std::span<const std::byte> frame) {
        Sent sent{.frame = copy(frame),
                  .datagram = {},
                  .number = ++from.sent,
                  .period = 0,
                  .by_connector = &from == &connector_};
        from.codec.wrap(frame, sent.datagram, now_);
        must(sent.datagram.size() <= frame.size() + longest_seal_bytes);
        if (std::exchange(from.key, sent.datagram[0]) != sent.datagram[0]) ++from.period;
        sent.period = from.period;
        sent_.push_back(std::move(sent));
    }

    void deliver(std::size_t which) {
        if (which >= sent_.size()) return;
        const Sent& sent = sent_[which];
        End& other = sent.by_connector ? listener_ : connector_;
        End& own = sent.by_connector ? connector_ : listener_;
        must(!is_taken(own.codec.unwrap(sent.datagram, own.frame, now_)));
        const Unwrapped how = other.codec.unwrap(sent.datagram, other.frame, now_);
        if (!is_taken(how)) {
            // What is newer than all before is refused only where the key has changed twice in between.
            must(sent.number <= other.newest || sent.period > other.newest_period + 1);
            return;
        }
        must(other.frame == sent.frame && other.taken.insert(sent.number).second);
        other.newest = std::max(other.newest, sent.number);
        other.newest_period = std::max(other.newest_period, sent.period);
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
        for (End* const end : {&connector_, &listener_})
            must(!is_taken(end->codec.unwrap(datagram, end->frame, now_)));
    }

    DatagramCodec::Time now_{};
    End connector_{.codec = DatagramCodec(key(1), key(2), now_)};
    End listener_{.codec = DatagramCodec(key(2), key(1), now_)};
    std::vector<Sent> sent_;
};

// Without keys everything that has the form is believed.
void run_plain(std::span<const std::byte> datagram) {
    DatagramCodec codec;
    Bytes frame;
    must(codec.unwrap(datagram, frame, {}) == Unwrapped::good);
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
