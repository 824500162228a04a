// Links over UDP and the serial line, and those that disturb them.
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <deque>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "afferent/io/links/datagram_connection.hpp"
#include "afferent/io/links/datagram_connector.hpp"
#include "afferent/io/links/datagram_listener.hpp"
#include "afferent/io/links/dtls.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "bench/serial_line.hpp"
#include "bench/short_lived_keys.hpp"
#include "tests/io/links/run_until.hpp"
#include "tests/io/links/turn_clock.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using Bytes = std::vector<std::byte>;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// One end of a link, and what it has received.
struct End {
    explicit operator bool() const { return link != nullptr; }
    void start() {
        link->start({.message =
                         [this](const proto::Envelope& message) {
                             messages.push_back(message);
                             if (on_message) on_message();
                         },
                     .bad_frame = [this](const Error&) { ++bad_frames; },
                     .closed = [this](const Error& error) { closed = error.text; }});
    }
    void send_position(std::uint32_t position) const {
        proto::Envelope packet;
        packet.set_position(position);
        link->send(packet);
    }
    std::vector<std::uint32_t> positions() const {
        std::vector<std::uint32_t> all;
        for (const auto& message : messages)
            if (message.position() != 0) all.push_back(message.position());
        return all;
    }

    std::unique_ptr<Link> link;
    std::function<void()> on_message;
    std::vector<proto::Envelope> messages;
    int bad_frames = 0;
    std::string closed;
};

class Datagrams : public testing::Test {
  protected:
    using Positions = std::vector<std::uint32_t>;

    void listen(const LinkAddress& address) {
        auto opened = open_listener(io_, address, options_);
        ASSERT_TRUE(opened) << opened.error().text;
        listener_ = std::move(opened).value();
        listener_->start([this](std::unique_ptr<Link> link) {
            peers_.emplace_back();
            peers_.back().link = std::move(link);
            peers_.back().start();
        });
    }

    // With a hello sent, as a session does.
    void connect(End& end, const LinkAddress& address, milliseconds patience = milliseconds(60'000)) {
        connectors_.push_back(make_connector(io_, address, {.limit = patience}, options_));
        connectors_.back()->start([this, &end](Result<std::unique_ptr<Link>> link) {
            if (!link) return void(failure_ = link.error().text);
            end.link = std::move(link).value();
            end.start();
            proto::Envelope hello;
            hello.mutable_hello();
            end.link->send(hello);
        });
    }

    // Why an attempt fails. Where the machine is too busy to answer in time, the next is given longer.
    std::string failure_of(const LinkAddress& address) {
        End stranger;
        for (milliseconds patience(100);; patience *= 2) {
            failure_.clear();
            connect(stranger, address, patience);
            run_until([&] { return !failure_.empty(); });
            if (failure_.find("no answer") == std::string::npos || patience > milliseconds(5000))
                return failure_;
        }
    }

    template <class Condition>
    void run_until(Condition condition) {
        afferent::run_until(io_, condition, [] {});
    }
    void run_for(milliseconds time) {
        io_.restart();
        io_.run_for(time);
    }
    std::uint16_t port() const { return std::get<UdpAddress>(listener_->address()).port; }

    ShortLivedKeys keys_;
    TlsCredentials hand_ = keys_.credentials(LinkEnd::hand);
    TlsCredentials coprocessor_ = keys_.credentials(LinkEnd::coprocessor);
    asio::io_context io_;
    // Whoever is silent is not lost by the test's being held up.
    LinkOptions options_{.silence_limit = milliseconds(10'000)};
    std::unique_ptr<Listener> listener_;
    std::vector<std::unique_ptr<Connector>> connectors_;
    std::deque<End> peers_;
    End near_;
    std::string failure_;
};

// Between a connector and a listener: passes on, remembers everything, and sends what it likes to the
// listener, from the address that the listener knows.
class LineInBetween {
  public:
    LineInBetween(asio::io_context& io, std::uint16_t to)
        : front_(io, udp::endpoint(asio::ip::address_v4::loopback(), 0)),
          back_(io, udp::endpoint(asio::ip::address_v4::loopback(), 0)),
          to_(asio::ip::address_v4::loopback(), to) {
        receive_in_front();
        receive_behind();
    }

    std::uint16_t port() const { return front_.local_endpoint().port(); }
    void send(std::span<const std::byte> datagram) {
        back_.send_to(asio::buffer(datagram.data(), datagram.size()), to_);
    }

    // From the address that the connector knows.
    void send_back(std::span<const std::byte> datagram) {
        front_.send_to(asio::buffer(datagram.data(), datagram.size()), connector_);
    }

    // From now on it is at another port.
    void move() {
        udp::socket other(front_.get_executor(), udp::endpoint(asio::ip::address_v4::loopback(), 0));
        back_ = std::move(other);
        receive_behind();
    }

    std::vector<Bytes> recording;                    // of what the connector has sent
    std::function<bool(Bytes&)> on_way_to_listener;  // false: it is kept back

  private:
    void receive_in_front() {
        front_.async_receive_from(asio::buffer(front_bytes_), connector_,
                                  [this](const boost::system::error_code& error, std::size_t count) {
                                      if (error) return;
                                      Bytes datagram(
                                          front_bytes_.begin(),
                                          front_bytes_.begin() + static_cast<std::ptrdiff_t>(count));
                                      recording.push_back(datagram);
                                      if (!on_way_to_listener || on_way_to_listener(datagram)) send(datagram);
                                      receive_in_front();
                                  });
    }
    void receive_behind() {
        back_.async_receive(asio::buffer(back_bytes_),
                            [this](const boost::system::error_code& error, std::size_t count) {
                                if (error) return;
                                front_.send_to(asio::buffer(back_bytes_.data(), count), connector_);
                                receive_behind();
                            });
    }

    udp::socket front_;
    udp::socket back_;
    udp::endpoint to_;
    udp::endpoint connector_;
    std::array<std::byte, 2000> front_bytes_{};
    std::array<std::byte, 2000> back_bytes_{};
};

// A link as it is within the machine, and as it is with keys.
class KeyedOrNot : public Datagrams, public testing::WithParamInterface<bool> {
  protected:
    LinkAddress address() const {
        return UdpAddress{"127.0.0.1", port(), GetParam() ? std::optional(coprocessor_) : std::nullopt};
    }
    void open() {
        listen(UdpAddress{"127.0.0.1", 0, GetParam() ? std::optional(hand_) : std::nullopt});
        connect(near_, address());
        run_until([&] { return peers_.size() == 1 && !peers_[0].messages.empty(); });
    }
};
INSTANTIATE_TEST_SUITE_P(Udp, KeyedOrNot, testing::Values(false, true),
                         [](const auto& keyed) { return keyed.param ? "sealed" : "plain"; });

class SealedUdp : public Datagrams {
  protected:
    void SetUp() override {
        options_.silence_limit = milliseconds(2000);
        listen(UdpAddress{"127.0.0.1", 0, hand_});
        relay_ = std::make_unique<LineInBetween>(io_, port());
    }
    LinkAddress through_relay() const { return UdpAddress{"127.0.0.1", relay_->port(), coprocessor_}; }
    void open() {
        connect(near_, through_relay());
        run_until([&] { return peers_.size() == 1 && !peers_[0].messages.empty(); });
    }

    std::unique_ptr<LineInBetween> relay_;
};

TEST_F(SealedUdp, CannotBeReadOrOpenedWithoutItsKey) {
    const auto failure_with = [&](const std::optional<TlsCredentials>& credentials) {
        return failure_of(UdpAddress{"127.0.0.1", port(), credentials});
    };
    EXPECT_NE(failure_with(std::nullopt).find("the listener has keys; give the scene link.keys"),
              std::string::npos)
        << failure_;
    const ShortLivedKeys others;
    EXPECT_NE(failure_with(others.credentials(LinkEnd::coprocessor))
                  .find("the peer's certificate is not the one that we hold of it"),
              std::string::npos)
        << failure_;
    // A stranger with the hand's certificate, which is public.
    TlsCredentials own = others.credentials(LinkEnd::coprocessor);
    own.peer_certificate = coprocessor_.peer_certificate;
    EXPECT_NE(failure_with(own).find("our certificate is not the one that the peer holds of us"),
              std::string::npos)
        << failure_;
    EXPECT_GE(listener_->refused_peers(), 2U);
    EXPECT_TRUE(peers_.empty());
}

// The keys of a stolen hand open no way to another hand's motor.
TEST_F(SealedUdp, TakesAHandsKeysForNoCoprocessor) {
    TlsCredentials stolen = hand_;
    stolen.peer_certificate = coprocessor_.peer_certificate;
    for (const TlsCredentials& credentials : {stolen, hand_}) {
        const std::string failure = failure_of(UdpAddress{"127.0.0.1", port(), credentials});
        EXPECT_NE(failure.find("certificate is not the one"), std::string::npos) << failure;
    }
    EXPECT_TRUE(peers_.empty());
}

TEST_F(Datagrams, ThatAreSealedDoNotReachAPlainListener) {
    listen(UdpAddress{"127.0.0.1", 0, std::nullopt});
    connect(near_, UdpAddress{"127.0.0.1", port(), coprocessor_}, milliseconds(100));
    run_until([&] { return !failure_.empty(); });
    EXPECT_NE(failure_.find("no answer from a listener with keys"), std::string::npos) << failure_;
    EXPECT_TRUE(peers_.empty());
}

TEST_F(Datagrams, ThatNobodyAnswersAreGivenUpWithoutAWordOfKeys) {
    connect(near_, UdpAddress{"127.0.0.1", 1, std::nullopt}, milliseconds(10));
    run_until([&] { return !failure_.empty(); });
    EXPECT_EQ(failure_, "udp:127.0.0.1:1: no answer (tried for 10 ms)");
}

// Somebody sends in the hand's name, without seeing what the coprocessor sends: before each of its datagrams
// reaches the hand, cookie requests and alerts, and what the coprocessor has said first.
TEST_F(SealedUdp, OpensWhileOthersSendInTheHandsName) {
    relay_->on_way_to_listener = [&](Bytes&) {
        const Bytes hello = relay_->recording.front();
        Bytes guessed = hello;
        std::fill(guessed.begin() + 3, guessed.begin() + 11, std::byte{0});
        for (unsigned number = 0; number < 4; ++number) {
            guessed[10] = std::byte(number);
            relay_->send_back(cookie_request(guessed, DtlsCookie{}));
            const std::array alert{std::byte{21}, std::byte{0xfe}, std::byte{0xfd}, std::byte{},
                                   std::byte{},   std::byte{},     std::byte{},     std::byte{},
                                   std::byte{},   std::byte{},     guessed[10],     std::byte{},
                                   std::byte{2},  std::byte{2},    std::byte{40}};
            relay_->send_back(alert);
        }
        relay_->send_back(hello);
        return true;
    };
    open();
    EXPECT_EQ(failure_, "");
}

TEST_F(SealedUdp, IsNotDisturbedByWhatIsForged) {
    open();
    std::mt19937 random(1);
    FrameWriter writer;
    int forged = 0;
    for (std::uint32_t position = 1; position <= 200; ++position) {
        near_.send_position(position);
        // Changed, cut short, made up; and plain, with a good checksum.
        for (int i = 0; i < 5; ++i) {
            Bytes datagram = relay_->recording.at(relay_->recording.size() - 1);
            if (i == 0) datagram[random() % datagram.size()] ^= std::byte{16};
            if (i == 1) datagram.resize(random() % datagram.size());
            if (i >= 2)
                for (std::byte& byte : datagram) byte = std::byte(random());
            if (i == 3) datagram[0] = std::byte(20 + random() % 64);
            if (i == 4) {
                proto::Envelope bye;
                bye.mutable_bye()->set_time_ns(0);
                const auto frame = writer.datagram(bye);
                datagram.assign(frame.begin(), frame.end());
            }
            relay_->send(datagram);
            ++forged;
        }
        run_until([&] { return peers_[0].positions().size() == position; });
    }
    EXPECT_EQ(peers_[0].bad_frames, 0);
    EXPECT_EQ(peers_[0].closed, "");
    EXPECT_EQ(peers_[0].messages.size(), 201U);
    EXPECT_EQ(peers_.size(), 1U);
    // A counter that was changed to an older one is taken for a repetition.
    run_until([&] {
        const FrameCounts& in = peers_[0].link->counts().in;
        return in.forged + in.repeated + 5 >= static_cast<unsigned>(forged);
    });
}

// It does not know the handshake that is under way, and answers nothing to it.
TEST_F(SealedUdp, BeginsAHandshakeAgainWithAListenerThatWasRestarted) {
    int come = 0;
    relay_->on_way_to_listener = [&](Bytes&) { return ++come <= 2; };
    connect(near_, through_relay());
    run_until([&] { return come > 4; });
    const UdpAddress address{"127.0.0.1", port(), hand_};
    listener_.reset();
    listen(address);
    relay_->on_way_to_listener = nullptr;
    run_until([&] { return !peers_.empty() && !peers_[0].messages.empty(); });
    EXPECT_EQ(failure_, "");
}

TEST_F(Datagrams, NameTheAddressThatAnotherHas) {
    listen(UdpAddress{"127.0.0.1", 0, std::nullopt});
    const auto second = open_listener(io_, UdpAddress{"127.0.0.1", port(), std::nullopt});
    ASSERT_FALSE(second);
    EXPECT_TRUE(second.error().text.starts_with("udp:127.0.0.1:" + std::to_string(port()) + ": "))
        << second.error().text;
}

// An old session, whole; and then the one that is going on.
TEST_F(SealedUdp, IsNotDisturbedByARecording) {
    open();
    for (std::uint32_t position = 1; position <= 20; ++position) near_.send_position(position);
    run_until([&] { return peers_[0].positions().size() == 20; });
    const std::vector<Bytes> old = std::exchange(relay_->recording, {});
    near_.link.reset();
    peers_[0].link.reset();
    for (const Bytes& datagram : old) relay_->send(datagram);
    run_for(milliseconds(50));
    run_all(io_);
    EXPECT_EQ(peers_.size(), 1U);  // it opens nothing

    connect(near_, through_relay());
    run_until([&] { return peers_.size() == 2 && !peers_[1].messages.empty(); });
    End& peer = peers_[1];
    for (std::uint32_t position = 101; position <= 120; ++position) {
        near_.send_position(position);
        for (const Bytes& datagram : old) relay_->send(datagram);
        run_until([&] { return peer.positions().size() == position - 100; });
        const auto ours = relay_->recording;
        for (const Bytes& datagram : ours) relay_->send(datagram);
        run_all(io_);  // so that the listener's buffer has room
    }
    EXPECT_EQ(peers_.size(), 2U);
    EXPECT_EQ(peer.positions().size(), 20U);
    EXPECT_EQ(peer.messages.size(), 21U);
    EXPECT_EQ(peer.closed, "");
    EXPECT_GT(peer.link->counts().in.forged, 100U);
    EXPECT_GT(peer.link->counts().in.repeated, 100U);
    // It still goes both ways.
    proto::Envelope status;
    status.mutable_status()->set_gain(0.5);
    peer.link->send(status);
    run_until([&] { return near_.messages.size() == 1; });
}

TEST_F(SealedUdp, TakesWhatWasOvertakenOnce) {
    open();
    Bytes kept;
    relay_->on_way_to_listener = [&](Bytes& datagram) {
        if (kept.empty()) {
            kept = datagram;
            return false;
        }
        return true;
    };
    near_.send_position(6);
    near_.send_position(11);
    run_until([&] { return !peers_[0].positions().empty(); });
    relay_->send(kept);
    run_until([&] { return peers_[0].positions().size() == 2; });
    EXPECT_EQ(peers_[0].positions(), (Positions{11, 6}));
    relay_->send(kept);
    run_until([&] { return peers_[0].link->counts().in.repeated == 1; });
    EXPECT_EQ(peers_[0].positions().size(), 2U);
}

// Two with the same keys: the second is told so while the first is alive, and takes its place when it is
// dead.
TEST_P(KeyedOrNot, TurnAwayASecondCoprocessorWhileTheFirstIsAlive) {
    options_.alive_limit = milliseconds(1500);
    open();
    End second;
    connect(second, address());
    std::uint32_t position = 0;
    const auto hello_again = [&] {
        near_.send_position(++position);
        proto::Envelope hello;
        hello.mutable_hello()->set_nonce(7);
        if (second) second.link->send(hello);
        run_for(milliseconds(20));
    };
    run_until([&] {
        hello_again();
        return !second.messages.empty();
    });
    EXPECT_EQ(second.messages.at(0).answer().refusal(), "another coprocessor is connected");
    EXPECT_TRUE(second.messages.at(0).answer().busy()) << "a later attempt may succeed";
    EXPECT_EQ(second.messages.at(0).answer().nonce(), 7U);
    EXPECT_EQ(peers_.size(), 1U);
    EXPECT_EQ(peers_[0].closed, "");
    EXPECT_GE(listener_->refused_peers(), 1U);
    // The first dies, and says nothing.
    near_.link.reset();
    second.link.reset();
    const auto began = std::chrono::steady_clock::now();
    run_for(options_.alive_limit);
    End third;
    connect(third, address());
    run_until([&] { return third.link != nullptr; });
    run_until([&] {
        proto::Envelope hello;
        hello.mutable_hello();
        third.link->send(hello);
        run_for(milliseconds(5));
        return peers_.size() == 2;
    });
    EXPECT_EQ(peers_[0].closed, "the coprocessor has started again");
    EXPECT_LT(std::chrono::steady_clock::now() - began, options_.silence_limit);
    third.send_position(6);
    run_until([&] { return peers_[1].positions().size() == 1; });
}

// As behind a router that was restarted: the peer is known by its key, and answers go to its present address.
TEST_F(SealedUdp, FollowsItsPeerToAnotherAddressByAuthenticationAlone) {
    open();
    near_.send_position(1);
    run_until([&] { return peers_[0].positions().size() == 1; });
    const Bytes old = relay_->recording.at(relay_->recording.size() - 1);
    relay_->move();
    // Neither a replayed nor a forged datagram moves it.
    relay_->send(old);
    Bytes forged = old;
    forged[1] ^= std::byte{64};
    relay_->send(forged);
    run_until([&] { return peers_[0].link->counts().in.forged == 1; });
    proto::Envelope status;
    status.mutable_status()->set_gain(0.5);
    peers_[0].link->send(status);
    run_for(milliseconds(20));
    EXPECT_TRUE(near_.messages.empty());
    near_.send_position(2);
    run_until([&] { return peers_[0].positions().size() == 2; });
    peers_[0].link->send(status);
    run_until([&] { return near_.messages.size() == 1; });
    EXPECT_EQ(peers_.size(), 1U);
}

TEST_F(Datagrams, OfAPlainLinkAreOfOneAddress) {
    listen(UdpAddress{"127.0.0.1", 0, std::nullopt});
    connect(near_, listener_->address());
    run_until([&] { return peers_.size() == 1 && peers_[0].messages.size() == 1; });
    udp::socket stranger(io_, udp::endpoint(asio::ip::address_v4::loopback(), 0));
    proto::Envelope message;
    message.mutable_bye();
    FrameWriter writer;
    const udp::endpoint to(asio::ip::address_v4::loopback(), port());
    for (int i = 0; i < 10; ++i) {
        const auto frame = writer.datagram(message);
        stranger.send_to(asio::buffer(frame.data(), frame.size()), to);
    }
    message.mutable_hello();
    const auto frame = writer.datagram(message);
    stranger.send_to(asio::buffer(frame.data(), frame.size()), to);
    run_until([&] { return listener_->refused_peers() == 1; });
    EXPECT_EQ(peers_[0].link->counts().in.forged, 10U);
    EXPECT_EQ(peers_[0].messages.size(), 1U);
    EXPECT_EQ(peers_.size(), 1U);
}

TEST_F(Datagrams, EndWhenThePeerIsSilentForTooLongAndNotBefore) {
    options_.silence_limit = milliseconds(400);
    listen(UdpAddress{"127.0.0.1", 0, hand_});
    // A peer with nothing to send still gives signs of life. Begins again where the test was held up for so
    // long that there could be none.
    Clock::duration longest_turn;
    do {
        longest_turn = {};
        near_ = End();
        peers_.clear();
        connect(near_, UdpAddress{"127.0.0.1", port(), coprocessor_});
        run_until([&] { return near_ && peers_.size() == 1; });
        for (const auto end = Clock::now() + milliseconds(600); Clock::now() < end;) {
            const auto before = Clock::now();
            run_for(milliseconds(10));
            longest_turn = std::max(longest_turn, Clock::now() - before);
        }
    } while (longest_turn > milliseconds(200));
    EXPECT_EQ(peers_[0].closed, "");
    EXPECT_EQ(near_.closed, "");
    near_.link.reset();
    run_until([&] { return !peers_[0].closed.empty(); });
    EXPECT_EQ(peers_[0].closed, "nothing has come from the peer for 400 ms");
}

TEST_F(Datagrams, HoldNoMoreThanADatagramCan) {
    listen(UdpAddress{"127.0.0.1", 0, hand_});
    connect(near_, UdpAddress{"127.0.0.1", port(), coprocessor_});
    run_until([&] { return peers_.size() == 1 && !peers_[0].messages.empty(); });
    proto::Envelope packet;
    packet.set_position(1);
    packet.set_payload(std::string(max_datagram_frame_bytes - 10, 'x'));
    ASSERT_EQ(FrameWriter().datagram(packet).size(), max_datagram_frame_bytes);
    EXPECT_TRUE(near_.link->send(packet));
    run_until([&] { return peers_[0].positions().size() == 1; });
    EXPECT_EQ(peers_[0].messages.back().payload(), packet.payload());
    packet.mutable_payload()->push_back('x');
    EXPECT_FALSE(near_.link->send(packet));
    run_until([&] { return !near_.closed.empty(); });
    EXPECT_NE(near_.closed.find("more than the 65487 that a datagram holds"), std::string::npos)
        << near_.closed;
}

// Takes nothing.
class FullPort final : public DatagramPort {
  public:
    void start(std::weak_ptr<DatagramPortUser>) override {}
    std::size_t send(const DatagramPeer&, std::span<const std::byte>) override { return 0; }
    void close() override {}
};

// As a session does whose user keeps it a while.
TEST_F(Datagrams, MayHearOfTheirPortAfterTheyHaveFailed) {
    const auto connection = std::make_shared<DatagramConnection>(
        io_, std::make_shared<FullPort>(), DatagramPeer(), DatagramCodec(), options_, nullptr);
    near_.link = std::make_unique<ConnectionLink>(connection);
    near_.start();
    near_.send_position(1);
    connection->fail({Error::Kind::closed, "unplugged"});
    EXPECT_EQ(near_.closed, "unplugged");
    connection->writable();
    EXPECT_FALSE(connection->lives());
}

// Two messages that are too large fail it twice, each in its turn of the loop.
TEST_F(Datagrams, SayOnceThatTheyHaveFailedAndNothingAfterThat) {
    const auto connection = std::make_shared<DatagramConnection>(
        io_, std::make_shared<FullPort>(), DatagramPeer(), DatagramCodec(), options_, nullptr);
    int failures = 0;
    connection->start({.message = [](const proto::Envelope&) { ADD_FAILURE() << "a message after the end"; },
                       .bad_frame = [](const Error&) { ADD_FAILURE() << "a bad frame after the end"; },
                       .closed = [&](const Error&) { ++failures; }});
    proto::Envelope message;
    message.set_payload(std::string(max_datagram_frame_bytes, 'x'));
    EXPECT_FALSE(connection->send(message));
    EXPECT_FALSE(connection->send(message));
    run_all(io_);
    message.set_payload("x");
    FrameWriter writer;
    connection->receive({}, writer.datagram(message));
    EXPECT_EQ(failures, 1);
}

// Carries nothing; the test speaks for it.
struct SilentPort final : DatagramPort {
    void start(std::weak_ptr<DatagramPortUser> its_user) override { user = std::move(its_user); }
    std::size_t send(const DatagramPeer&, std::span<const std::byte> datagram) override {
        sent.emplace_back(datagram.begin(), datagram.end());
        return datagram.size();
    }
    void close() override { closed = true; }

    std::weak_ptr<DatagramPortUser> user;
    std::vector<Bytes> sent;
    bool closed = false;
};

// As a serial line that is unplugged before anybody has answered.
TEST_F(Datagrams, OpenTheirPortAgainIfItFailsDuringTheAttempt) {
    std::vector<std::shared_ptr<SilentPort>> ports;
    const auto open = [&]() -> Result<std::shared_ptr<DatagramPort>> {
        ports.push_back(std::make_shared<SilentPort>());
        return std::shared_ptr<DatagramPort>(ports.back());
    };
    const auto connector =
        make_datagram_connector(io_, UdpAddress{"127.0.0.1", 1, std::nullopt}, open, DtlsContext(),
                                {milliseconds(1), milliseconds(1), milliseconds(60'000)}, options_);
    bool connected = false;
    connector->start([&](const Result<std::unique_ptr<Link>>& link) { connected = link.has_value(); });
    run_until([&] { return ports.size() == 1; });
    ports[0]->user.lock()->failed({Error::Kind::closed, "unplugged"});
    ASSERT_TRUE(ports[0]->closed);
    run_until([&] { return ports.size() == 2; });
    const std::byte reply = byte_of(DatagramKind::reply);
    ports[1]->user.lock()->received({}, std::span(&reply, 1));
    EXPECT_TRUE(connected);
}

// After 1, 2, 4, 8 and 16 ms; 32 ms later its patience is over.
TEST_F(Datagrams, AreRepeatedAfterPausesThatDouble) {
    const auto port = std::make_shared<SilentPort>();
    const auto connector = make_datagram_connector(
        io_, UdpAddress{"127.0.0.1", 1, std::nullopt},
        [&]() -> Result<std::shared_ptr<DatagramPort>> { return {port}; }, DtlsContext(),
        {milliseconds(1), milliseconds(1000), milliseconds(60)}, options_);
    bool given_up = false;
    connector->start([&](const auto&) { given_up = true; });
    run_until([&] { return given_up; });
    EXPECT_GT(port->sent.size(), 1U);
    EXPECT_LE(port->sent.size(), 6U);
}

TEST_F(Datagrams, OpenNoPortForAnAttemptThatWasCalledOffBeforeItBegan) {
    int opened = 0;
    const auto open = [&]() -> Result<std::shared_ptr<DatagramPort>> {
        ++opened;
        return std::shared_ptr<DatagramPort>(std::make_shared<SilentPort>());
    };
    auto connector = make_datagram_connector(io_, UdpAddress{"127.0.0.1", 1, std::nullopt}, open,
                                             DtlsContext(), {}, options_);
    connector->start([](const auto&) { ADD_FAILURE() << "it was called off"; });
    connector.reset();
    run_all(io_);
    EXPECT_EQ(opened, 0);
}

TEST_F(SealedUdp, RepeatsTheHelloOfOneHandshakeWhereNobodyAnswers) {
    const auto port = std::make_shared<SilentPort>();
    const auto connector = make_datagram_connector(
        io_, through_relay(), [&]() -> Result<std::shared_ptr<DatagramPort>> { return {port}; },
        make_dtls_context(coprocessor_), {}, options_);
    connector->start([](const auto&) { ADD_FAILURE() << "nobody has answered"; });
    run_until([&] { return port->sent.size() == 2; });
    const auto first = client_hello(port->sent[0]);
    const auto second = client_hello(port->sent[1]);
    ASSERT_TRUE(first && second);
    EXPECT_EQ(first->random, second->random) << "another handshake";
}

// A listener with keys, and a coprocessor's handshake with it that is under way.
class BegunHandshake : public Datagrams {
  protected:
    void SetUp() override {
        listener_ = make_datagram_listener(io_, UdpAddress{"127.0.0.1", 1, hand_}, port_, {},
                                           value_or_throw(make_dtls_context(hand_)), options_);
        listener_->start([](const auto&) { ADD_FAILURE() << "no handshake has ended"; });
        kept_ = port_->user.lock();
        coprocessor_handshake_.start();
        ASSERT_EQ(port_->sent.size(), 1U) << "a request to return a cookie";
        const Bytes request = port_->sent[0];
        coprocessor_handshake_.receive(request);
        ASSERT_GT(port_->sent.size(), 1U) << "the hand's certificate";
    }

    std::shared_ptr<SilentPort> port_ = std::make_shared<SilentPort>();
    std::shared_ptr<DatagramPortUser> kept_;  // as a link keeps it that the listener has handed over
    DtlsHandshake coprocessor_handshake_{value_or_throw(make_dtls_context(coprocessor_)),
                                         DtlsHandshake::Role::connects, port_->line(),
                                         [this](auto datagram) { kept_->received({}, datagram); }};
};

TEST_F(BegunHandshake, IsRepeatedWhileThereIsAListenerAndNoLonger) {
    const std::size_t sent = port_->sent.size();
    run_until([&] { return port_->sent.size() > sent; });
    listener_.reset();
    run_all(io_);
    EXPECT_TRUE(io_.stopped()) << "it waits for the time to repeat it once more";
}

// Both times have come before the loop runs, so that the tick is in its queue when the port goes.
TEST_F(BegunHandshake, MayLoseItsPortInTheTurnInWhichItIsLookedAfter) {
    asio::steady_timer before(io_, milliseconds(0));
    before.async_wait([this](const boost::system::error_code&) {
        listener_.reset();
        kept_.reset();
    });
    std::this_thread::sleep_for(milliseconds(20));
    run_all(io_);
    EXPECT_TRUE(port_->user.expired());
    EXPECT_TRUE(port_->closed);
}

class Serial : public Datagrams {
  protected:
    LinkAddress first(std::uint32_t baud = 921'600) const {
        return SerialAddress{line_.first(), baud, hand_};
    }
    LinkAddress second(std::uint32_t baud = 921'600) const {
        return SerialAddress{line_.second(), baud, coprocessor_};
    }
    void open(std::uint32_t baud = 921'600) {
        listen(first(baud));
        connect(near_, second(baud));
        run_until([&] { return peers_.size() == 1 && !peers_[0].messages.empty(); });
    }

    SerialLine line_{io_};
};

TEST_F(Serial, GoesOnAfterGarbage) {
    open();
    std::mt19937 random(3);
    std::uint32_t position = 0;
    for (int round = 0; round < 50; ++round) {
        std::string noise(1 + random() % 2000, '\0');
        for (char& byte : noise) byte = static_cast<char>(random());
        line_.disturb_first(noise);
        near_.send_position(++position);
        run_until([&] { return peers_[0].positions().size() == position; });
    }
    EXPECT_EQ(peers_[0].closed, "");
    EXPECT_EQ(peers_[0].bad_frames, 0);
    EXPECT_GT(peers_[0].link->counts().in.forged, 0U);
}

// Noise on the line: what it hits is lost, and nothing else.
TEST_F(Serial, LosesLittleToNoiseEveryTenMilliseconds) {
    std::mt19937 random(5);
    // A loop that is slow, and as long as it is, is not disturbed more often.
    TurnClock time(2ms);
    auto last = time.now();
    const auto disturb = [&] {
        time.turn();
        if (time.now() < last + milliseconds(10)) return;
        last = time.now();
        std::string noise(300, '\0');
        for (char& byte : noise) byte = static_cast<char>(random());
        line_.disturb_first(noise);
        line_.disturb_second(noise);
    };
    listen(first());
    connect(near_, second());
    afferent::run_until(
        io_, [&] { return peers_.size() == 1 && !peers_[0].messages.empty(); }, disturb);
    for (std::uint32_t position = 1; position <= 200; ++position) {
        near_.send_position(position);
        run_for(milliseconds(2));
        disturb();
    }
    // A frame is lost where noise comes into it while it is read.
    run_until([&] { return peers_[0].positions().size() >= 150; });
    EXPECT_EQ(peers_[0].bad_frames, 0);
    EXPECT_EQ(peers_[0].closed, "");
}

TEST_F(Serial, LosesWhatIsChangedOnItsWayAndNothingElse) {
    open();
    std::mt19937 random(4);
    std::size_t changed = 0;
    bool disturbing = true;
    line_.on_way_to_first = [&](std::string& bytes) {
        if (!disturbing || random() % 4 != 0) return;
        bytes[random() % bytes.size()] ^= 8;
        ++changed;
    };
    std::uint32_t position = 0;
    while (position < 200 || (changed <= 10 && position < 20'000)) {
        near_.send_position(++position);
        run_for(milliseconds(1));
    }
    EXPECT_GT(changed, 10U);
    disturbing = false;
    near_.send_position(++position);
    near_.send_position(++position);
    run_until([&] { return !peers_[0].positions().empty() && peers_[0].positions().back() == position; });
    // A changed end joins two.
    EXPECT_GE(peers_[0].positions().size() + 2 * changed, position);
    EXPECT_EQ(peers_[0].bad_frames, 0);
    EXPECT_EQ(peers_[0].closed, "");
}

TEST_F(Serial, IsForOneProgramAlone) {
    open();
    const auto second_listener = open_listener(io_, first());
    ASSERT_FALSE(second_listener);
    EXPECT_NE(second_listener.error().text.find("another program has opened it"), std::string::npos)
        << second_listener.error().text;
}

TEST_F(Serial, SaysWhatADeviceCannotDo) {
    const auto odd = open_listener(io_, first(12'345));
    ASSERT_FALSE(odd);
    EXPECT_NE(odd.error().text.find("does not support 12345 baud"), std::string::npos) << odd.error().text;
    const auto none = open_listener(io_, SerialAddress{"/nowhere/ttyS0", 9600, hand_});
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().text, "serial:/nowhere/ttyS0: No such file or directory");
    EXPECT_FALSE(open_listener(io_, SerialAddress{"/dev/null", 9600, hand_}));
}

// More than the line takes: nothing blocks, the oldest give way, and what arrives is fresh.
TEST_F(Serial, DropsTheOldestPacketsWhereTheLineIsTooSlow) {
    constexpr std::uint32_t baud = 38'400;
    open(baud);
    const PacketLayout layout{.addresses = 9};
    PacketReceiver receiver(layout);
    Packetizer packetizer(layout);
    // The scene's clock: it does not run while the test is held up.
    TurnClock time(20ms);
    const auto began = time.now();
    const auto since = [&] { return Duration(time.now() - began); };
    Duration worst_age{};
    std::size_t seen = 0;
    const auto take = [&] {
        for (; seen < peers_[0].messages.size(); ++seen) {
            if (peers_[0].messages[seen].position() == 0) continue;
            const auto reception = receiver.receive(peers_[0].messages[seen]);
            ASSERT_TRUE(reception) << reception.error().text;
            worst_age = std::max(worst_age, since() - (reception.value().known.end - scene_start));
        }
    };
    peers_[0].on_message = take;
    std::vector<Event> events;
    std::uint64_t sent = 0;
    for (int span = 0; span < 160; ++span) {
        // 40 events in 5 ms: about 50 bytes sealed, against 19 that the line takes.
        events.clear();
        for (Address i = 0; i < 40; ++i) events.push_back({scene_start + span * 5ms + (i / 9) * 1ms, i % 9});
        sent += events.size();
        packetizer.push(events);
        run_until([&] {
            time.turn();
            return since() >= (span + 1) * 5ms;
        });
        packetizer.close(scene_start + (span + 1) * 5ms, [&](const proto::Envelope& packet) {
            if (!near_.link->send(packet)) packetizer.announce();
        });
    }
    const auto& counts = receiver.counts();
    run_until([&] {
        time.turn();
        return counts.packets == packetizer.packets() - near_.link->counts().dropped;
    });
    run_for(milliseconds(20));  // and no more
    receiver.finish(scene_start + 800ms, sent);
    EXPECT_GT(near_.link->counts().dropped, 40U);
    EXPECT_EQ(counts.packets, packetizer.packets() - near_.link->counts().dropped);
    EXPECT_EQ(counts.events + counts.lost_events, sent);
    // A tenth of a second waits in the queue, and more than a second would if it had no limit. The rest is
    // how late a busy machine may make it.
    EXPECT_LT(worst_age, 600ms);
}

// On a busy machine.
TEST_F(Serial, MakesUpForALoopThatWasHeldUp) {
    open(115'200);
    proto::Envelope packet;
    packet.set_payload(std::string(60, 'x'));  // some 9 ms on the line
    for (std::uint32_t position = 1; position <= 100; ++position) {
        packet.set_position(position);
        near_.link->send(packet);
        if (position % 2 != 0) continue;
        std::this_thread::sleep_for(milliseconds(25));
        io_.restart();
        io_.poll();
    }
    EXPECT_EQ(near_.link->counts().dropped, 0U);
    run_until([&] { return peers_[0].positions().size() == 100; });
}

TEST_F(Serial, IsOpenedAgainAfterTheDeviceWasGone) {
    auto line = std::make_unique<SerialLine>(io_);
    const std::string link_path = testing::TempDir() + "afferent-tty-" + std::to_string(::getpid());
    ASSERT_EQ(::symlink(line->first().c_str(), link_path.c_str()), 0);
    listen(SerialAddress{link_path, 921'600, hand_});
    connect(near_, SerialAddress{line->second(), 921'600, coprocessor_});
    run_until([&] { return peers_.size() == 1; });
    ::unlink(link_path.c_str());
    line.reset();  // unplugged
    run_until([&] { return !peers_[0].closed.empty() && !near_.closed.empty(); });
    EXPECT_NE(peers_[0].closed.find("the serial line has failed"), std::string::npos) << peers_[0].closed;
    ASSERT_EQ(::symlink(line_.first().c_str(), link_path.c_str()), 0);
    End again;
    connect(again, second());
    run_until([&] { return peers_.size() == 2; });
    ::unlink(link_path.c_str());
}

}  // namespace
}  // namespace afferent
