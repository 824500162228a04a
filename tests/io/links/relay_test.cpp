// The relay by itself: what it cuts, delays, loses and passes on. Sessions over it are tested in
// faults_test.cpp.
#include "afferent/io/links/relay.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <filesystem>
#include <random>

#include "afferent/io/links/endpoints.hpp"
#include "afferent/io/links/stream_cutter.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/proto/aer.pb.h"
#include "tests/io/links/hello_message.hpp"
#include "tests/io/links/run_until.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using Local = asio::local::stream_protocol;

std::vector<std::byte> bytes_of(const std::string& text) {
    const auto* const begin = reinterpret_cast<const std::byte*>(text.data());
    return {begin, begin + text.size()};
}

std::vector<std::string> cut(CutInto pieces, std::span<const std::byte> bytes, std::size_t at_once) {
    StreamCutter cutter(pieces);
    std::vector<std::string> found;
    for (std::size_t i = 0; i < bytes.size(); i += at_once)
        cutter.push(bytes.subspan(i, std::min(at_once, bytes.size() - i)),
                    [&](std::span<const std::byte> piece) {
                        found.emplace_back(reinterpret_cast<const char*>(piece.data()), piece.size());
                    });
    return found;
}

TEST(StreamCutter, FindsFramesHoweverTheStreamComes) {
    FrameWriter writer;
    std::vector<std::byte> stream;
    std::vector<std::string> frames;
    for (std::uint32_t i = 1; i < 300; i += 7) {
        proto::Envelope packet;
        packet.set_position(i);
        packet.set_payload(std::string(i, 'x'));
        const auto frame = writer.stream_frame(packet);
        stream.insert(stream.end(), frame.begin(), frame.end());
        frames.emplace_back(reinterpret_cast<const char*>(frame.data()), frame.size());
    }
    for (const std::size_t at_once : {1UL, 2UL, 17UL, stream.size()})
        EXPECT_EQ(cut(CutInto::frames, stream, at_once), frames);
}

TEST(StreamCutter, FindsSegments) {
    const auto bytes = bytes_of(std::string("ab\0c\0\0d", 7));
    const std::vector<std::string> segments{std::string("ab\0", 3), std::string("c\0", 2),
                                            std::string(1, '\0')};
    EXPECT_EQ(cut(CutInto::segments, bytes, 1), segments);
    EXPECT_EQ(cut(CutInto::segments, bytes, 7), segments);
}

TEST(StreamCutter, PassesOnWhatIsNoStreamOfFrames) {
    const auto bytes = bytes_of("\xff\xff\xff\xff garbage");
    std::string all;
    for (const std::string& piece : cut(CutInto::frames, bytes, 3)) all += piece;
    EXPECT_EQ(bytes_of(all), bytes);
}

TEST(ChannelAddress, IsNextToTheHands) {
    EXPECT_EQ(text(channel_address(UnixAddress{"/a/hand.sock"})), "unix:/a/hand.sock.channel");
    EXPECT_EQ(text(channel_address(TcpAddress{"127.0.0.1", 7450})), "tcp:127.0.0.1:7451");
    EXPECT_EQ(text(channel_address(UdpAddress{"127.0.0.1", 7450, {}})), "udp:127.0.0.1:7451");
}

class Relays : public testing::Test {
  protected:
    template <class Condition>
    void run_until(Condition condition) {
        afferent::run_until(io_, condition, [] {});
    }

    // Two ends with the relay between them.
    void connect(const LinkAddress& hand, const RelayParameters& parameters) {
        auto opened = open_listener(io_, hand);
        ASSERT_TRUE(opened) << opened.error().text;
        listener_ = std::move(opened).value();
        listener_->start([this](std::unique_ptr<Link> link) {
            hand_ = std::move(link);
            hand_->start({[this](const proto::Envelope& packet) {
                              if (!packet.has_hello()) received_.push_back(packet.position());
                          },
                          [](const Error&) {}, [this](const Error& error) { closed_ = error.text; }});
        });
        LinkAddress from = listener_->address();
        if (auto* const tcp = std::get_if<TcpAddress>(&from)) tcp->port = 0;
        if (auto* const unix_address = std::get_if<UnixAddress>(&from)) unix_address->path += ".channel";
        auto relay = Relay::open(io_, from, listener_->address(), parameters);
        ASSERT_TRUE(relay) << relay.error().text;
        relay_ = std::move(relay).value();
        connector_ = make_connector(io_, relay_->address());
        connector_->start([this](Result<std::unique_ptr<Link>> link) {
            ASSERT_TRUE(link) << link.error().text;
            coprocessor_ = std::move(link).value();
            coprocessor_->start(
                {[this](const proto::Envelope& packet) { back_.push_back(packet.position()); },
                 [](const Error&) {}, [](const Error&) {}});
        });
        run_until([&] { return coprocessor_ != nullptr; });
    }

    // Until a hello has got through, and no other is under way.
    void say_hello() {
        hellos_ = 0;
        run_until([&] {
            const ChannelCounts counts = relay_->counts().to_hand;
            if (counts.sent < hellos_ || counts.arrived + counts.lost < hellos_) return false;
            if (hand_) return true;
            coprocessor_->send(hello_message());
            ++hellos_;
            return false;
        });
    }

    void send(Link& link, std::uint32_t count) {
        for (std::uint32_t i = 1; i <= count; ++i) {
            proto::Envelope packet;
            packet.set_position(i);
            link.send(packet);
        }
    }

    static std::vector<LinkAddress> addresses() {
        return {UnixAddress{std::filesystem::temp_directory_path() /
                            ("afferent-relay-" + std::to_string(getpid()))},
                TcpAddress{"127.0.0.1", 0}};
    }

    asio::io_context io_;
    std::unique_ptr<Listener> listener_;
    std::unique_ptr<Relay> relay_;
    std::unique_ptr<Connector> connector_;
    std::unique_ptr<Link> hand_;
    std::unique_ptr<Link> coprocessor_;
    std::vector<std::uint32_t> received_;
    std::vector<std::uint32_t> back_;
    std::string closed_;
    std::uint64_t hellos_ = 0;
};

// A hand that accepts whoever comes.
TEST_F(Relays, HaveAtMostSixteenConnections) {
    const std::string path =
        (std::filesystem::temp_directory_path() / ("afferent-relay-" + std::to_string(getpid()))).string();
    Local::acceptor hand(io_, path);
    std::vector<Local::socket> held;
    std::function<void()> accept = [&] {
        hand.async_accept([&](const boost::system::error_code& error, Local::socket socket) {
            if (error) return;
            held.push_back(std::move(socket));
            accept();
        });
    };
    accept();
    relay_ = value_or_throw(Relay::open(io_, UnixAddress{path + ".channel"}, UnixAddress{path}, {}));
    std::vector<Local::socket> coprocessors;
    int closed = 0;
    char byte = 0;
    for (int i = 0; i < 17; ++i) {
        coprocessors.emplace_back(io_).connect(path + ".channel");
        coprocessors.back().async_read_some(asio::buffer(&byte, 1),
                                            [&](const boost::system::error_code& error, std::size_t) {
                                                closed += error == asio::error::eof ? 1 : 0;
                                            });
    }
    run_until([&] { return closed > 0 && held.size() >= 16; });
    EXPECT_EQ(held.size(), 16U);
    EXPECT_EQ(closed, 1);
    std::filesystem::remove(path);
}

TEST_F(Relays, PassOnBothWaysAndTheEnd) {
    for (const LinkAddress& hand : addresses()) {
        received_.clear(), back_.clear(), closed_.clear();
        connect(hand, {});
        say_hello();
        send(*coprocessor_, 500);
        send(*hand_, 300);
        run_until([&] { return received_.size() == 500 && back_.size() == 300; });
        EXPECT_EQ(received_.back(), 500U);
        EXPECT_EQ(relay_->counts().to_hand.arrived, 500U + hellos_);
        EXPECT_EQ(relay_->counts().to_coprocessor.arrived, 300U);
        EXPECT_EQ(listener_->strays(), 0U) << "a stream has none";
        coprocessor_.reset();
        run_until([&] { return !closed_.empty(); });
        hand_.reset();
    }
}

TEST_F(Relays, LoseAndCountWholeFrames) {
    for (const LinkAddress& hand : addresses()) {
        received_.clear();
        RelayParameters parameters;
        parameters.to_hand.loss = 0.25;
        connect(hand, parameters);
        say_hello();
        const std::uint64_t arrived = relay_->counts().to_hand.arrived;
        send(*coprocessor_, 1000);
        run_until([&] {
            const ChannelCounts counts = relay_->counts().to_hand;
            return counts.sent == hellos_ + 1000 && counts.arrived == arrived + received_.size() &&
                   counts.arrived + counts.lost == hellos_ + 1000;
        });
        EXPECT_NEAR(static_cast<double>(received_.size()), 750, 60);  // four standard deviations
        EXPECT_TRUE(std::is_sorted(received_.begin(), received_.end()));
        coprocessor_.reset();
        hand_.reset();
    }
}

TEST_F(Relays, KeepToTheClock) {
    RelayParameters parameters;
    parameters.to_hand.latency = 50ms;
    connect(addresses()[0], parameters);
    say_hello();
    const auto began = std::chrono::steady_clock::now();
    send(*coprocessor_, 1);
    run_until([&] { return received_.size() == 1; });
    EXPECT_GE(std::chrono::steady_clock::now() - began, std::chrono::milliseconds(50));
}

TEST_F(Relays, DeliverWhatAnEndHasSentBeforeItClosed) {
    RelayParameters parameters;
    parameters.to_hand.latency = 50ms;
    connect(addresses()[0], parameters);
    say_hello();
    send(*coprocessor_, 20);
    run_until([&] { return relay_->counts().to_hand.sent == hellos_ + 20; });
    coprocessor_.reset();
    run_until([&] { return !closed_.empty(); });
    EXPECT_EQ(received_.size(), 20U);
}

TEST_F(Relays, PassNothingWhenPulledAndTellNobody) {
    connect(addresses()[1], {});
    say_hello();
    relay_->pull(true);
    send(*coprocessor_, 10);
    io_.restart();
    io_.run_for(std::chrono::milliseconds(30));
    run_all(io_);
    EXPECT_TRUE(received_.empty());
    EXPECT_TRUE(closed_.empty());
    relay_->pull(false);
    send(*coprocessor_, 10);
    run_until([&] { return received_.size() == 10; });
}

TEST_F(Relays, PassNothingOfWhoComesWhilePulled) {
    connect(addresses()[1], {});
    relay_->pull(true);
    coprocessor_.reset();
    connector_ = make_connector(io_, relay_->address());
    connector_->start([this](Result<std::unique_ptr<Link>> link) {
        coprocessor_ = value_or_throw(std::move(link));
        coprocessor_->start({[](const proto::Envelope&) {}, [](const Error&) {}, [](const Error&) {}});
    });
    run_until([&] { return coprocessor_ != nullptr; });
    coprocessor_->send(hello_message());
    io_.restart();
    io_.run_for(std::chrono::milliseconds(30));
    run_all(io_);
    EXPECT_EQ(hand_, nullptr);
    relay_->pull(false);
    say_hello();
    EXPECT_NE(hand_, nullptr);
}

TEST_F(Relays, StandInForASerialLine) {
    const auto device = std::filesystem::temp_directory_path() / ("afferent-tty-" + std::to_string(getpid()));
    constexpr std::uint32_t baud = 9600;
    const SerialAddress hand{device.string(), baud, {}};
    auto opened = Relay::open(io_, channel_address(hand), hand, {});
    ASSERT_TRUE(opened) << opened.error().text;
    const int at_coprocessor = ::open((device.string() + ".channel").c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    const int at_hand = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    ASSERT_GE(at_coprocessor, 0);
    ASSERT_GE(at_hand, 0);
    const std::string said("segment\0and more\0", 17);
    const auto began = std::chrono::steady_clock::now();
    ASSERT_EQ(::write(at_coprocessor, said.data(), said.size()), 17);
    std::string heard;
    run_until([&] {
        std::array<char, 64> space;
        const ssize_t count = ::read(at_hand, space.data(), space.size());
        if (count > 0) heard.append(space.data(), static_cast<std::size_t>(count));
        return heard.size() >= 17;
    });
    EXPECT_EQ(heard, said);
    EXPECT_GE(std::chrono::steady_clock::now() - began, 17 * 10 * std::chrono::seconds(1) / baud)
        << "faster than the line";
    EXPECT_EQ(opened.value()->counts().connections, 1U);
    ::close(at_coprocessor);
    ::close(at_hand);
    opened.value().reset();
    EXPECT_FALSE(std::filesystem::is_symlink(device));
}

TEST_F(Relays, LeaveTheMachineNoMoreThanALinkDoes) {
    const auto refusal = [&](const LinkAddress& from, const LinkAddress& to) {
        const auto relay = Relay::open(io_, from, to, {});
        return relay ? std::string() : relay.error().text;
    };
    const std::string reason = "only a link with keys may";
    EXPECT_NE(refusal(TcpAddress{"0.0.0.0", 0}, TcpAddress{"127.0.0.1", 1}).find(reason), std::string::npos);
    EXPECT_NE(refusal(TcpAddress{"127.0.0.1", 0}, TcpAddress{"192.0.2.1", 1}).find(reason),
              std::string::npos);
    EXPECT_NE(refusal(UdpAddress{"0.0.0.0", 0, {}}, UdpAddress{"127.0.0.1", 1, {}}).find(reason),
              std::string::npos);
    const UnixAddress too_long{std::string(108, 'x')};
    EXPECT_NE(refusal(too_long, UnixAddress{"/tmp/x"}).find("1 to 107"), std::string::npos);
    EXPECT_TRUE(endpoint_of(UnixAddress{std::string(107, 'x')}));
}

TEST_F(Relays, CountWhatIsRepeatedAlsoAfterItsConnectionHasEnded) {
    RelayParameters parameters;
    parameters.to_hand.duplicate = 1;
    connect(addresses()[0], parameters);
    say_hello();
    run_until([&] { return relay_->counts().to_hand.arrived == 2 * hellos_; });
    EXPECT_EQ(relay_->counts().to_hand.duplicated, hellos_);
    coprocessor_.reset();
    run_until([&] { return !closed_.empty(); });
    EXPECT_EQ(relay_->counts().to_hand.duplicated, hellos_);
}

// Whichever step towards the connection was the last.
TEST_F(Relays, MakeNoConnectionOnceTheyAreGone) {
    const UnixAddress at_hand = std::get<UnixAddress>(addresses()[0]);
    const Local::acceptor hand(io_, at_hand.path);
    for (int steps = 0; steps < 5; ++steps) {
        const LinkAddress from = channel_address(at_hand);
        auto relay = value_or_throw(Relay::open(io_, from, at_hand, {}));
        Local::socket coprocessor(io_);
        coprocessor.connect(std::get<UnixAddress>(from).path);
        io_.restart();
        for (int step = 0; step < steps; ++step) io_.poll_one();
        relay.reset();
        run_all(io_);
        EXPECT_TRUE(io_.stopped()) << "something is left to do after step " << steps;
    }
    std::filesystem::remove(at_hand.path);
}

// However long the delay is.
TEST_F(Relays, HoldNoMoreThanTheyMay) {
    RelayParameters parameters;
    parameters.to_hand.latency = 1000s;
    connect(addresses()[1], parameters);
    asio::ip::tcp::socket flood(io_);
    const auto address = std::get<TcpAddress>(relay_->address());
    coprocessor_.reset(), hand_.reset();
    flood.connect({asio::ip::make_address(address.host), address.port});
    flood.non_blocking(true);
    const std::string garbage(std::size_t{64} * 1024, '\xff');
    std::size_t taken = 0;
    int in_vain = 0;
    // Until nothing has been taken for a while in which the test was not held up.
    for (auto last = std::chrono::steady_clock::now();
         (std::chrono::steady_clock::now() < last + std::chrono::milliseconds(200) || in_vain < 1000) &&
         taken < 128U << 20;
         ++in_vain) {
        boost::system::error_code error;
        if (const std::size_t count = flood.send(asio::buffer(garbage), 0, error); !error) {
            taken += count;
            last = std::chrono::steady_clock::now();
            in_vain = 0;
        }
        io_.restart();
        io_.poll();
    }
    EXPECT_GT(taken, std::size_t{1} << 20);
    // The kernel's buffers come on top.
    EXPECT_LT(taken, std::size_t{20} << 20);
    // Nobody waits for room in a relay that is gone.
    relay_.reset(), listener_.reset(), connector_.reset();
    io_.restart();
    io_.run_for(std::chrono::seconds(10));
    EXPECT_TRUE(io_.stopped());
}

// An end is gone, and what it has sent is still under way.
TEST_F(Relays, WaitForADeliveryWithoutHaste) {
    RelayParameters parameters;
    parameters.to_hand.latency = 1000s;
    connect(addresses()[0], parameters);
    send(*coprocessor_, 1);
    run_until([&] { return relay_->counts().to_hand.sent == 1; });
    coprocessor_.reset();
    io_.restart();
    // It looks once in a millisecond.
    EXPECT_LT(io_.run_for(std::chrono::milliseconds(50)), 100U);
}

// Nothing that is under way either way.
TEST_F(Relays, OfDatagramsLeaveNothingToDoWhenTheyAreGone) {
    for (const bool is_answer : {false, true}) {
        RelayParameters parameters;
        (is_answer ? parameters.to_coprocessor : parameters.to_hand).latency = 1000s;
        const asio::ip::udp::endpoint loopback(asio::ip::address_v4::loopback(), 0);
        asio::ip::udp::socket hand(io_, loopback);
        asio::ip::udp::socket coprocessor(io_, loopback);
        auto relay = value_or_throw(Relay::open(io_, UdpAddress{"127.0.0.1", 0, {}},
                                                UdpAddress{"127.0.0.1", hand.local_endpoint().port(), {}},
                                                parameters));
        const std::array<std::byte, 3> datagram{};
        coprocessor.send_to(asio::buffer(datagram),
                            {loopback.address(), std::get<UdpAddress>(relay->address()).port});
        run_until([&] { return relay->counts().to_hand.sent == 1; });
        if (is_answer) {
            std::array<std::byte, 10> space;
            asio::ip::udp::endpoint from;
            ASSERT_EQ(hand.receive_from(asio::buffer(space), from), datagram.size());
            hand.send_to(asio::buffer(datagram), from);
            run_until([&] { return relay->counts().to_coprocessor.sent == 1; });
        }
        EXPECT_EQ(relay->counts().connections, 1U);
        relay.reset();
        run_all(io_);
        EXPECT_TRUE(io_.stopped());
    }
}

TEST_F(Relays, ReplaceNoLinkButTheirOwn) {
    const std::string file = testing::TempDir() + "afferent-no-tty-" + std::to_string(getpid());
    const std::string device = file + ".link";
    std::filesystem::create_symlink(file, device);
    const SerialAddress hand{device, 115'200, {}};
    EXPECT_FALSE(Relay::open(io_, channel_address(hand), hand, {}));
    EXPECT_EQ(std::filesystem::read_symlink(device), file);
    std::filesystem::remove(device);
    // The link of a relay that was killed.
    std::filesystem::create_symlink("/dev/pts/999999", device);
    EXPECT_TRUE(Relay::open(io_, channel_address(hand), hand, {}));
    EXPECT_FALSE(std::filesystem::is_symlink(device));
    EXPECT_FALSE(std::filesystem::is_symlink(device + ".channel"));
}

// Without a descriptor to spare a peer cannot be accepted, and stays where it is.
TEST_F(Relays, AndListenersWaitForDescriptorsWithoutHaste) {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the sanitizer takes descriptors of its own to look at memory";
#endif
    for (const bool at_relay : {false, true}) {
        connect(addresses()[1], {});
        const auto address = std::get<TcpAddress>(at_relay ? relay_->address() : listener_->address());
        asio::ip::tcp::socket peer(io_, asio::ip::tcp::v4());
        rlimit before{};
        ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
        const rlimit none{3, before.rlim_max};
        ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
        boost::system::error_code error;
        peer.connect({asio::ip::make_address(address.host), address.port}, error);
        io_.restart();
        const std::size_t handlers = io_.run_for(std::chrono::milliseconds(300));
        ::setrlimit(RLIMIT_NOFILE, &before);
        EXPECT_FALSE(error) << error.message();
        EXPECT_LT(handlers, 50U);
        coprocessor_.reset(), hand_.reset();
    }
}

}  // namespace
}  // namespace afferent
