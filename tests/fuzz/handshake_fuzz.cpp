// Datagrams from anybody to a listener with keys, mixed with those of a peer's handshake, in any order and
// from any address: no state is kept for an address that has not returned its cookie, no more is sent to it
// than it has sent, only a few peers are remembered, and nobody without the keys gets a session.
#include <algorithm>
#include <filesystem>
#include <vector>

#include "afferent/io/links/certificate.hpp"
#include "afferent/io/links/dtls_acceptor.hpp"
#include "afferent/io/links/key_folder.hpp"
#include "fuzz.hpp"

namespace afferent {
namespace {

using Bytes = std::vector<std::byte>;

Bytes copy(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

DatagramPeer peer_at(std::uint8_t number) {
    return {boost::asio::ip::address_v4::loopback(), static_cast<unsigned short>(1 + number % 4)};
}

// The contexts of both ends, made once.
struct Contexts {
    Contexts() {
        std::string name = (std::filesystem::temp_directory_path() / "afferent-fuzz-XXXXXX").string();
        must(::mkdtemp(name.data()) != nullptr);
        const KeyFolder keys{name};
        for (const LinkEnd link_end : {LinkEnd::coprocessor, LinkEnd::hand})
            must(write_certificate(afferent::name(link_end), keys.certificate(link_end),
                                   keys.private_key(link_end))
                     .has_value());
        hand = make_dtls_context(keys.credentials(LinkEnd::hand)).value();
        coprocessor = make_dtls_context(keys.credentials(LinkEnd::coprocessor)).value();
        std::filesystem::remove_all(name);
    }

    DtlsContext hand;
    DtlsContext coprocessor;
};

const Contexts& contexts() {
    static const Contexts both;
    return both;
}

class Acceptance {
  public:
    void run(FuzzInput& input) {
        connector_.start();
        while (!input.empty()) step(input);
    }

  private:
    void step(FuzzInput& input) {
        const std::uint8_t choice = input.byte();
        now_ += std::chrono::milliseconds(5);
        switch (choice % 5) {
            case 0:  // what the peer has sent, as it is
                if (const std::size_t which = input.byte(); which < sent_.size())
                    receive(peer_at(choice / 5), sent_[which]);
                return;
            case 1: {  // or changed, cut short or made longer
                const std::size_t which = input.byte();
                if (which >= sent_.size()) return;
                Bytes datagram = sent_[which];
                const std::size_t place = input.byte() + std::size_t{256} * (choice / 5 % 3);
                const std::uint8_t change = input.byte();
                if (place >= datagram.size())
                    datagram.push_back(std::byte{change});
                else if (change == 0)
                    datagram.resize(place);
                else
                    datagram[place] ^= std::byte{change};
                return receive(peer_at(choice / 5 % 2), datagram);
            }
            case 2:  // what the listener has answered reaches the peer
                if (const std::size_t which = input.byte(); which < answers_.size())
                    connector_.receive(answers_[which]);
                return;
            case 3:
                now_ += std::chrono::milliseconds(100) * input.byte();
                acceptor_.look_after(now_);
                return;
            default:
                return receive(peer_at(choice / 5), input.bytes(input.byte()));
        }
    }

    void receive(const DatagramPeer& from, std::span<const std::byte> datagram) {
        const std::size_t peers = acceptor_.peers();
        const std::size_t answers = answers_.size();
        if (is_dtls(datagram)) {
            acceptor_.receive(from, datagram, now_);
            must(acceptor_.peers() <= DtlsAcceptor::most_peers);
            // One cookie at most, which is shorter than the question.
            if (acceptor_.peers() == 0 && peers == 0 && answers_.size() > answers)
                must(answers_.size() == answers + 1 && answers_.back().size() <= datagram.size() + 32);
        }
        Bytes frame;
        must(acceptor_.peer_of(from, datagram, frame, now_) == nullptr);
    }

    static void bound(std::vector<Bytes>& all, std::span<const std::byte> datagram) {
        if (all.size() < 64) all.push_back(copy(datagram));
    }

    DtlsAcceptor::Time now_ = DtlsAcceptor::Time() + std::chrono::hours(1);
    std::vector<Bytes> sent_;
    std::vector<Bytes> answers_;
    DtlsHandshake connector_{
        contexts().coprocessor, DtlsHandshake::Role::connects, {}, [this](auto datagram) {
            bound(sent_, datagram);
        }};
    DtlsAcceptor acceptor_{
        contexts().hand, {}, [this](const DatagramPeer&, auto datagram) { bound(answers_, datagram); }};
};

}  // namespace
}  // namespace afferent

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    FuzzInput input(data, size);
    Acceptance().run(input);
    return 0;
}
