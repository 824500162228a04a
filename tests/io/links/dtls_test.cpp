// The handshake of a sealed datagram link: over lines that lose and reorder, and against peers without the
// keys that try to open a session or to keep others from it.
#include <gtest/gtest.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

#include <chrono>
#include <deque>
#include <random>
#include <string>
#include <thread>

#include "afferent/io/links/dtls_acceptor.hpp"
#include "bench/short_lived_keys.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

using Bytes = std::vector<std::byte>;
using Role = DtlsHandshake::Role;
using State = DtlsHandshake::State;
using std::chrono::milliseconds;

Bytes copy(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

DatagramPeer peer_at(unsigned short port) { return {boost::asio::ip::address_v4::loopback(), port}; }

// A connector and an acceptor, and what is under way between them.
class Handshakes : public testing::Test {
  protected:
    struct Sent {
        DatagramPeer peer;
        Bytes datagram;
    };

    static DtlsContext context(const TlsCredentials& credentials) {
        return value_or_throw(make_dtls_context(credentials));
    }
    DtlsContext context(LinkEnd link_end) const { return context(keys_.credentials(link_end)); }

    std::unique_ptr<DtlsHandshake> connector(const DtlsContext& with) {
        return std::make_unique<DtlsHandshake>(with, Role::connects, line_, [this](auto datagram) {
            EXPECT_LE(datagram.size(), line_.handshake_bytes);
            to_acceptor_.push_back(copy(datagram));
        });
    }
    std::unique_ptr<DtlsHandshake> connector() { return connector(context(LinkEnd::coprocessor)); }

    // Carries everything until nothing is under way.
    void carry(DtlsHandshake& connector, DtlsAcceptor& acceptor, const DatagramPeer& from = peer_at(1)) {
        while (!to_acceptor_.empty() || !to_connector_.empty()) {
            if (!to_acceptor_.empty()) {
                recording_.push_back(to_acceptor_.at(0));
                acceptor.receive(from, recording_.back(), now_);
                to_acceptor_.pop_front();
            }
            if (!to_connector_.empty()) {
                connector.receive(to_connector_.at(0).datagram);
                to_connector_.pop_front();
            }
        }
    }
    // The peer that the acceptor recognises in a datagram sealed by the connector.
    DtlsAcceptor::Peer* opened(const DtlsHandshake& connector, DtlsAcceptor& acceptor,
                               const DatagramPeer& from = peer_at(1)) {
        DatagramCodec codec = value_or_throw(connector.codec(now_));
        const Bytes said = copy(std::as_bytes(std::span("hello")));
        Bytes frame;
        codec.wrap(said, sealed_, now_);
        auto* const peer = acceptor.peer_of(from, sealed_, frame, now_);
        EXPECT_TRUE(peer == nullptr || frame == said);
        return peer;
    }
    bool opens(const DtlsHandshake& connector, DtlsAcceptor& acceptor,
               const DatagramPeer& from = peer_at(1)) {
        return opened(connector, acceptor, from) != nullptr;
    }

    ShortLivedKeys keys_;
    DatagramLine line_;
    DtlsAcceptor::Time now_ = DtlsAcceptor::Time::clock::now();
    std::deque<Bytes> to_acceptor_;
    std::deque<Sent> to_connector_;
    Bytes sealed_;
    std::vector<Bytes> recording_;  // of what the connector has sent
    DtlsAcceptor acceptor_{context(LinkEnd::hand), line_, [this](const DatagramPeer& to, auto datagram) {
                               to_connector_.push_back({to, copy(datagram)});
                           }};
};

TEST_F(Handshakes, GiveBothEndsTheKeysOfASession) {
    const auto handshake = connector();
    handshake->start();
    carry(*handshake, acceptor_);
    ASSERT_EQ(handshake->state(), State::done) << handshake->failure();
    EXPECT_TRUE(opens(*handshake, acceptor_));
    // Another session has others.
    const auto another = connector();
    another->start();
    carry(*another, acceptor_, peer_at(2));
    ASSERT_EQ(another->state(), State::done);
    EXPECT_FALSE(opens(*another, acceptor_, peer_at(1)));
    EXPECT_TRUE(opens(*another, acceptor_, peer_at(2)));
}

// The two directions have keys of their own: nobody takes what it has sent itself, thrown back at it.
TEST_F(Handshakes, GiveEachDirectionItsOwnKeys) {
    const auto handshake = connector();
    handshake->start();
    carry(*handshake, acceptor_);
    ASSERT_EQ(handshake->state(), State::done) << handshake->failure();
    DatagramCodec codec = value_or_throw(handshake->codec(now_));
    Bytes frame;
    codec.wrap(copy(std::as_bytes(std::span("hello"))), sealed_, now_);
    EXPECT_EQ(codec.unwrap(sealed_, frame, now_), DatagramCodec::Unwrapped::forged);
}

// Fragments included: a serial line takes short datagrams.
TEST_F(Handshakes, GetThroughALineThatLosesDoublesAndShuffles) {
    std::mt19937 random(1);
    line_.handshake_bytes = 300;
    DtlsAcceptor acceptor(context(LinkEnd::hand), line_, [this](const DatagramPeer& to, auto datagram) {
        to_connector_.push_back({to, copy(datagram)});
    });
    const DtlsContext own = context(LinkEnd::coprocessor);
    int done = 0;
    for (int i = 0; i < 3; ++i) {
        const DatagramPeer from = peer_at(static_cast<unsigned short>(i + 1));
        // An attempt may fail for good, as a flight lost many times over; the connector begins another.
        for (int attempt = 0; attempt < 20; ++attempt) {
            const auto handshake = connector(own);
            handshake->start();
            const auto until = std::chrono::steady_clock::now() + milliseconds(2000);
            while (handshake->state() == State::under_way && std::chrono::steady_clock::now() < until) {
                now_ = std::chrono::steady_clock::now();
                std::shuffle(to_acceptor_.begin(), to_acceptor_.end(), random);
                std::shuffle(to_connector_.begin(), to_connector_.end(), random);
                for (; !to_acceptor_.empty(); to_acceptor_.pop_front())
                    for (auto times = random() % 5; times > 0; times /= 2)  // none, once, or more
                        acceptor.receive(from, to_acceptor_.at(0), now_);
                for (; !to_connector_.empty(); to_connector_.pop_front())
                    for (auto times = random() % 5; times > 0; times /= 2)
                        if (to_connector_.at(0).peer == from)
                            handshake->receive(to_connector_.at(0).datagram);
                handshake->look_after();
                acceptor.look_after(now_);
                std::this_thread::sleep_for(milliseconds(1));
            }
            if (handshake->state() != State::done) continue;
            EXPECT_TRUE(opens(*handshake, acceptor, from));
            ++done;
            break;
        }
    }
    EXPECT_EQ(done, 3);
}

TEST_F(Handshakes, RememberNobodyBeforeACookieIsReturned) {
    const DtlsContext own = context(LinkEnd::coprocessor);
    for (unsigned short i = 1; i <= 200; ++i) {
        const auto handshake = connector(own);
        handshake->start();
        ASSERT_TRUE(acceptor_.receive(peer_at(i), to_acceptor_.at(0), now_));
        to_acceptor_.clear();
    }
    EXPECT_EQ(acceptor_.peers(), 0U);
    // Each is answered, by less than it has sent.
    ASSERT_EQ(to_connector_.size(), 200U);
    for (const Sent& sent : to_connector_) EXPECT_LT(sent.datagram.size(), 100U);
}

// A peer that forges another's address does not see its cookie.
TEST_F(Handshakes, TakeACookieFromItsAddressAlone) {
    const auto handshake = connector();
    handshake->start();
    acceptor_.receive(peer_at(1), to_acceptor_.at(0), now_);
    to_acceptor_.clear();
    handshake->receive(to_connector_.at(0).datagram);
    const Bytes with_cookie = to_acceptor_.at(0);
    acceptor_.receive(peer_at(2), with_cookie, now_);
    EXPECT_EQ(acceptor_.peers(), 0U);
    acceptor_.receive(peer_at(1), with_cookie, now_);
    EXPECT_EQ(acceptor_.peers(), 1U);
}

// A second time, in the handshake itself: the acceptor has looked before.
TEST_F(Handshakes, TakeNoCookieButTheirs) {
    const auto handshake = connector();
    handshake->start();
    const DtlsCookie theirs{1, 2, 3};
    handshake->receive(cookie_request(to_acceptor_.at(0), theirs));
    const Bytes with_cookie = to_acceptor_.at(1);
    const auto listens = [&](const DtlsCookies& cookies) {
        DtlsHandshake listener(context(LinkEnd::hand), Role::listens, line_, [](auto) {});
        return listener.listen(with_cookie, cookies);
    };
    EXPECT_FALSE(listens({DtlsCookie{4}, DtlsCookie{5}}));
    EXPECT_TRUE(listens({theirs, DtlsCookie{5}}));
    EXPECT_TRUE(listens({DtlsCookie{4}, theirs}));
}

// The number of the message is that of none of a connector's hellos.
TEST_F(Handshakes, RememberNobodyWhoseHelloIsRefusedThoughItsCookieIsRight) {
    const auto handshake = connector();
    handshake->start();
    acceptor_.receive(peer_at(1), to_acceptor_.at(0), now_);
    to_acceptor_.clear();
    handshake->receive(to_connector_.at(0).datagram);
    Bytes with_cookie = to_acceptor_.at(0);
    with_cookie.at(13 + 5) = std::byte{9};
    EXPECT_FALSE(acceptor_.receive(peer_at(1), with_cookie, now_));
    EXPECT_EQ(acceptor_.peers(), 0U);
    EXPECT_EQ(acceptor_.refused(), 0U);
}

TEST_F(Handshakes, TakeACookieForAWhile) {
    const auto handshake = connector();
    handshake->start();
    acceptor_.receive(peer_at(1), to_acceptor_.at(0), now_);
    to_acceptor_.clear();
    handshake->receive(to_connector_.at(0).datagram);
    acceptor_.receive(peer_at(1), to_acceptor_.at(0), now_ + 2 * DtlsAcceptor::cookie_time);
    EXPECT_EQ(acceptor_.peers(), 0U);
}

TEST_F(Handshakes, OfARecordingOpenNothing) {
    const auto handshake = connector();
    handshake->start();
    carry(*handshake, acceptor_);
    ASSERT_EQ(handshake->state(), State::done);
    auto* const peer = opened(*handshake, acceptor_);
    ASSERT_NE(peer, nullptr);
    acceptor_.remove(*peer);  // it has its session
    const auto replay = [&](DtlsAcceptor& to) {
        for (int round = 0; round < 3; ++round)
            for (const Bytes& datagram : std::vector(recording_)) {
                to.receive(peer_at(1), datagram, now_);
                Bytes frame;
                EXPECT_EQ(to.peer_of(peer_at(1), sealed_, frame, now_), nullptr);
            }
        to_connector_.clear();
    };
    // To the same listener at once and later, and to another with the same keys.
    replay(acceptor_);
    now_ += 3 * DtlsAcceptor::cookie_time;
    acceptor_.look_after(now_);
    replay(acceptor_);
    DtlsAcceptor another(context(LinkEnd::hand), line_, [](const DatagramPeer&, auto) {});
    replay(another);
    EXPECT_EQ(another.peers(), 0U);
    // A peer with the keys still comes in.
    const auto next = connector();
    next->start();
    carry(*next, acceptor_);
    ASSERT_EQ(next->state(), State::done) << next->failure();
    EXPECT_TRUE(opens(*next, acceptor_));
}

TEST_F(Handshakes, KeepAFewPlacesForASecond) {
    const DtlsContext own = context(LinkEnd::coprocessor);
    // As many as the rate lets begin, over three seconds; none goes on.
    std::uint64_t begun = 0;
    std::size_t most = 0;
    for (unsigned short i = 1; i <= 300; ++i) {
        now_ += milliseconds(10);
        const auto handshake = connector(own);
        handshake->start();
        acceptor_.receive(peer_at(i), to_acceptor_.at(0), now_);
        to_acceptor_.clear();
        if (to_connector_.empty()) continue;
        handshake->receive(to_connector_.at(0).datagram);
        to_connector_.clear();
        if (!to_acceptor_.empty() && acceptor_.receive(peer_at(i), to_acceptor_.at(0), now_)) ++begun;
        to_acceptor_.clear();
        most = std::max(most, acceptor_.peers());
    }
    EXPECT_EQ(most, 16U);
    EXPECT_LE(begun, 4 * 20U) << "20 at once, and 20 in a second";
    // In the middle of that crowd, one that goes on.
    now_ += milliseconds(500);
    const auto handshake = connector(own);
    handshake->start();
    carry(*handshake, acceptor_, peer_at(5000));
    EXPECT_EQ(handshake->state(), State::done) << handshake->failure();
    now_ += DtlsHandshake::patience(line_) + milliseconds(1);
    acceptor_.look_after(now_);
    EXPECT_EQ(acceptor_.peers(), 0U);
}

// A peer that has shown its certificate, and more than there are places for that only begin.
TEST_F(Handshakes, ThatAreDoneKeepTheirPlaceInACrowdThatIsNot) {
    const DtlsContext own = context(LinkEnd::coprocessor);
    const auto handshake = connector(own);
    handshake->start();
    carry(*handshake, acceptor_, peer_at(5000));
    ASSERT_EQ(handshake->state(), State::done) << handshake->failure();
    for (std::uint32_t host = 1; host <= 20; ++host) {
        now_ += milliseconds(60);
        const DatagramPeer from{boost::asio::ip::address_v4(host), 1};
        const auto stranger = connector(own);
        stranger->start();
        acceptor_.receive(from, to_acceptor_.at(0), now_);
        to_acceptor_.clear();
        ASSERT_FALSE(to_connector_.empty());
        stranger->receive(to_connector_.front().datagram);
        EXPECT_TRUE(acceptor_.receive(from, to_acceptor_.at(0), now_));
        to_acceptor_.clear();
        to_connector_.clear();
    }
    EXPECT_EQ(acceptor_.peers(), 16U);
    EXPECT_TRUE(opens(*handshake, acceptor_, peer_at(5000)));
}

TEST_F(Handshakes, AnswerNoMoreThanSoManyInASecond) {
    const auto handshake = connector();
    handshake->start();
    const Bytes hello = to_acceptor_.at(0);
    std::uint64_t answered = 0;
    for (int i = 0; i < 50'000; ++i) {
        now_ += std::chrono::microseconds(20);
        answered += acceptor_.receive(peer_at(1), hello, now_) ? 1 : 0;
    }
    EXPECT_LE(answered, 2 * 500U + 1);
    EXPECT_GE(answered, 500U);
}

// As many as a link takes, whatever addresses they claim to come from.
TEST_F(Handshakes, AFloodOfHellosFromEverywhereKeepsNobodyOut) {
    const auto stranger = connector();
    stranger->start();
    const Bytes hello = to_acceptor_.at(0);
    to_acceptor_.clear();
    std::mt19937 random(6);
    std::uint64_t answered = 0;
    const auto flood_for = [&](milliseconds length) {
        for (const auto end = now_ + length; now_ < end; now_ += std::chrono::microseconds(20)) {
            const DatagramPeer from{boost::asio::ip::address_v4(static_cast<std::uint32_t>(random())),
                                    static_cast<unsigned short>(random())};
            answered += acceptor_.receive(from, hello, now_) ? 1 : 0;
            to_connector_.clear();
        }
    };
    flood_for(milliseconds(500));
    EXPECT_GT(answered, 20'000U);
    EXPECT_EQ(acceptor_.peers(), 0U);
    for (unsigned short port = 1; port <= 5; ++port) {
        const auto handshake = connector();
        handshake->start();
        carry(*handshake, acceptor_, peer_at(port));
        EXPECT_EQ(handshake->state(), State::done) << handshake->failure();
        EXPECT_TRUE(opens(*handshake, acceptor_, peer_at(port)));
        flood_for(milliseconds(50));
    }
}

TEST_F(Handshakes, OneAddressThatBeginsManyKeepsNoOtherOut) {
    const DtlsContext own = context(LinkEnd::coprocessor);
    const auto address = boost::asio::ip::make_address("10.1.2.3");
    int begun = 0;
    for (unsigned short port = 1; port <= 200; ++port) {
        now_ += milliseconds(1);
        const auto handshake = connector(own);
        handshake->start();
        acceptor_.receive({address, port}, to_acceptor_.at(0), now_);
        to_acceptor_.clear();
        ASSERT_FALSE(to_connector_.empty());
        handshake->receive(to_connector_.at(0).datagram);
        to_connector_.clear();
        begun += acceptor_.receive({address, port}, to_acceptor_.at(0), now_) ? 1 : 0;
        to_acceptor_.clear();
        to_connector_.clear();
    }
    EXPECT_GE(begun, 20);
    EXPECT_LE(begun, 30);
    const auto handshake = connector(own);
    handshake->start();
    carry(*handshake, acceptor_);
    EXPECT_EQ(handshake->state(), State::done) << handshake->failure();
}

TEST_F(Handshakes, WithoutTheRightCertificateAreRefusedInWords) {
    const ShortLivedKeys others;
    const auto failure = [&](const TlsCredentials& with) {
        const auto handshake = connector(context(with));
        handshake->start();
        carry(*handshake, acceptor_, peer_at(9));
        EXPECT_EQ(handshake->state(), State::failed);
        EXPECT_EQ(::ERR_peek_error(), 0U) << "an error is left to whoever uses OpenSSL next";
        return handshake->failure();
    };
    EXPECT_EQ(failure(others.credentials(LinkEnd::coprocessor)),
              "the peer's certificate is not the one that we hold of it");
    TlsCredentials own = others.credentials(LinkEnd::coprocessor);
    own.peer_certificate = keys_.folder().certificate(LinkEnd::hand);
    EXPECT_EQ(failure(own), "our certificate is not the one that the peer holds of us");
    // A hand's keys, stolen.
    TlsCredentials stolen = keys_.credentials(LinkEnd::hand);
    stolen.peer_certificate = keys_.folder().certificate(LinkEnd::hand);
    EXPECT_EQ(failure(stolen), "our certificate is not the one that the peer holds of us");
    EXPECT_EQ(acceptor_.peers(), 0U);
    EXPECT_EQ(acceptor_.refused(), 3U);
}

TEST_F(Handshakes, WithoutAnyCertificateAreRefusedInWords) {
    const DtlsContext bare(::SSL_CTX_new(::DTLS_method()), ::SSL_CTX_free);
    ASSERT_TRUE(bare);
    ::SSL_CTX_set_options(bare.get(), SSL_OP_NO_QUERY_MTU);
    const auto handshake = connector(bare);
    handshake->start();
    carry(*handshake, acceptor_);
    EXPECT_EQ(handshake->state(), State::failed);
    EXPECT_NE(handshake->failure().find("handshake failure"), std::string::npos) << handshake->failure();
    EXPECT_EQ(acceptor_.peers(), 0U);
    EXPECT_EQ(acceptor_.refused(), 1U);
}

// Without encryption, by somebody who sees nothing of the handshake and knows its form.
Bytes made_up(unsigned kind, unsigned number, std::initializer_list<unsigned> content) {
    Bytes record{std::byte(kind),
                 std::byte{0xfe},
                 std::byte{0xfd},
                 {},
                 {},
                 {},
                 {},
                 {},
                 {},
                 {},
                 std::byte(number),
                 {},
                 std::byte(content.size())};
    for (const unsigned byte : content) record.push_back(std::byte(byte));
    return record;
}

// In the other end's name, before and after everything that it sends itself.
TEST_F(Handshakes, GoOnPastWhatOthersMakeUpInTheNameOfEitherEnd) {
    const auto handshake = connector();
    handshake->start();
    const Bytes hello = to_acceptor_.front();
    Bytes guessed = hello;
    std::fill(guessed.begin() + 3, guessed.begin() + 11, std::byte{0});
    const auto forge = [&](const auto& receive) {
        for (unsigned number = 0; number < 8; ++number) {
            guessed[10] = std::byte(number);
            receive(copy(cookie_request(guessed, DtlsCookie{})));
            receive(made_up(21, number, {2, 40}));  // an alert
            receive(
                made_up(22, number, {2, 0, 0, 2, 0, 1, 0, 0, 0, 0, 0, 2, 0xfe, 0xfd}));  // a server's hello
            receive(made_up(22, number, {14, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}));         // its end
            receive(made_up(22, number, {16, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}));         // a client's key
            receive(made_up(20, number, {1}));                                           // a change of keys
        }
    };
    while (!to_acceptor_.empty() || !to_connector_.empty()) {
        forge([&](const Bytes& forged) { acceptor_.receive(peer_at(1), forged, now_); });
        forge([&](const Bytes& forged) { handshake->receive(forged); });
        handshake->receive(hello);  // sent back
        ASSERT_EQ(handshake->state() == State::failed, false) << handshake->failure();
        if (!to_acceptor_.empty()) {
            const Bytes datagram = to_acceptor_.front();
            to_acceptor_.pop_front();
            acceptor_.receive(peer_at(1), datagram, now_);
        } else {
            const Bytes datagram = to_connector_.front().datagram;
            to_connector_.pop_front();
            handshake->receive(datagram);
        }
    }
    ASSERT_EQ(handshake->state(), State::done) << handshake->failure();
    EXPECT_TRUE(opens(*handshake, acceptor_));
}

TEST_F(Handshakes, WithACookieThatWasChangedFailAtOnceAndNotWhenTheirTimeIsOver) {
    const auto handshake = connector();
    handshake->start();
    handshake->look_after();
    acceptor_.receive(peer_at(1), to_acceptor_.front(), now_);
    acceptor_.receive(peer_at(1), to_acceptor_.front(), now_);  // twice
    to_acceptor_.clear();
    Bytes changed = to_connector_.front().datagram;
    changed.back() ^= std::byte{1};
    const Bytes doubled = to_connector_.back().datagram;
    to_connector_.clear();
    handshake->receive(changed);
    handshake->receive(doubled);
    EXPECT_EQ(handshake->state(), State::under_way);
    ASSERT_FALSE(to_acceptor_.empty());
    acceptor_.receive(peer_at(1), to_acceptor_.front(), now_);
    ASSERT_FALSE(to_connector_.empty());
    Bytes grown = to_connector_.front().datagram;
    grown.resize(grown.size() + 12);
    handshake->receive(grown);
    EXPECT_EQ(handshake->state(), State::under_way) << "a datagram that does not consist of whole records";
    carry(*handshake, acceptor_);
    EXPECT_EQ(handshake->state(), State::failed);
    EXPECT_NE(handshake->failure().find("cookie"), std::string::npos) << handshake->failure();
}

TEST_F(Handshakes, ThatAreDoneAreNotUndoneByALateRequestForACookie) {
    const auto handshake = connector();
    handshake->start();
    acceptor_.receive(peer_at(1), to_acceptor_.at(0), now_);
    to_acceptor_.clear();
    handshake->receive(to_connector_.at(0).datagram);
    to_connector_.clear();
    const Bytes with_cookie = to_acceptor_.at(0);
    carry(*handshake, acceptor_);
    ASSERT_EQ(handshake->state(), State::done) << handshake->failure();
    handshake->receive(cookie_request(with_cookie, DtlsCookie{}));
    EXPECT_EQ(handshake->state(), State::done) << handshake->failure();
    EXPECT_TRUE(opens(*handshake, acceptor_));
}

TEST_F(Handshakes, DropDatagramsThatDoNotConsistOfWholeRecords) {
    const auto handshake = connector();
    handshake->start();
    acceptor_.receive(peer_at(1), to_acceptor_.at(0), now_);
    to_acceptor_.clear();
    const Bytes asked = to_connector_.at(0).datagram;
    // Behind a whole record, less than the head of another.
    Bytes grown = asked;
    grown.resize(asked.size() + 12);
    handshake->receive(grown);
    EXPECT_EQ(to_acceptor_.size(), 0U);
    handshake->receive(asked);
    EXPECT_EQ(to_acceptor_.size(), 1U);
}

TEST_F(Handshakes, SurviveWhateverElseIsSentToThem) {
    std::mt19937 random(4);
    const auto handshake = connector();
    handshake->start();
    const Bytes hello = to_acceptor_.at(0);
    for (int i = 0; i < 20'000; ++i) {
        Bytes changed = hello;
        changed.resize(random() % (hello.size() + 20));
        if (!changed.empty()) changed[random() % changed.size()] ^= std::byte(1 << random() % 8);
        now_ += milliseconds(5);
        if (is_dtls(changed)) acceptor_.receive(peer_at(1), changed, now_);
    }
    EXPECT_EQ(acceptor_.peers(), 0U);
    to_connector_.clear();
    carry(*handshake, acceptor_);
    EXPECT_EQ(handshake->state(), State::done) << handshake->failure();
}

}  // namespace
}  // namespace afferent
