// TLS between two ends that hold each other's certificates, and everybody else.
#include "afferent/io/links/tls.hpp"

#include <gtest/gtest.h>
#include <openssl/ssl.h>
#include <sodium.h>
#include <sys/stat.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>
#include <fstream>

#include "afferent/io/links/certificate.hpp"
#include "afferent/io/links/key_file.hpp"
#include "afferent/io/links/secret_memory.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/proto/aer.pb.h"
#include "tests/io/links/dumped_memory.hpp"
#include "tests/io/links/hello_message.hpp"
#include "tests/io/links/run_until.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

class Tls : public testing::Test {
  protected:
    Tls() {
        std::string name = (std::filesystem::temp_directory_path() / "afferent-tls-XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
        for (const char* link_end : {"coprocessor", "hand", "stranger"}) {
            const auto written = write_certificate(link_end, crt(link_end), key(link_end));
            EXPECT_TRUE(written) << written.error().text;
        }
    }
    ~Tls() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path crt(const std::string& link_end) const { return folder_ / (link_end + ".crt"); }
    std::filesystem::path key(const std::string& link_end) const { return folder_ / (link_end + ".key"); }
    TlsCredentials credentials(const std::string& own, const std::string& peer) const {
        return {crt(own), key(own), crt(peer)};
    }

    void listen(const TlsCredentials& with) {
        auto opened = open_listener(io_, TlsAddress{"127.0.0.1", 0, with});
        ASSERT_TRUE(opened) << opened.error().text;
        listener_ = std::move(opened).value();
        port_ = std::get<TlsAddress>(listener_->address()).port;
        listener_->start([this](std::unique_ptr<Link> link) {
            accepted_ = std::move(link);
            accepted_->start({[this](const proto::Envelope& message) {
                                  if (!message.has_hello()) received_.push_back(message.position());
                              },
                              [](const Error&) {}, [this](const Error& error) { closed_ = error.text; }});
        });
    }

    void connect(const LinkAddress& address) {
        connector_ = make_connector(
            io_, address,
            {std::chrono::milliseconds(1), std::chrono::milliseconds(9), std::chrono::seconds(30)});
        connector_->start([this](Result<std::unique_ptr<Link>> link) {
            if (!link) return void(refusal_ = link.error());
            connected_ = std::move(link).value();
            connected_->start(
                {[this](const proto::Envelope& message) { answer_ = message.answer().refusal(); },
                 [](const Error&) {}, [this](const Error& error) { refusal_ = error; }});
            connected_->send(hello_message());
            proto::Envelope packet;
            packet.set_position(7);
            connected_->send(packet);
        });
    }

    template <class Condition>
    void run_until(Condition condition) {
        afferent::run_until(io_, condition, [] {});
    }

    // A stranger with other software, which says hello once it may; why it is turned away.
    error_code refusal_of_a_stranger(const std::function<void(asio::ssl::context&)>& prepare) {
        asio::ssl::context context(asio::ssl::context::tls_client);
        prepare(context);
        asio::ssl::stream<tcp::socket> stream(io_, context);
        stream.lowest_layer().connect({asio::ip::make_address("127.0.0.1"), port_});
        std::optional<error_code> said;
        std::array<char, 1> byte;
        FrameWriter writer;
        const std::span<const std::byte> frame = writer.stream_frame(hello_message());
        stream.async_handshake(asio::ssl::stream_base::client, [&](const error_code& error) {
            if (error) return void(said = error);
            asio::async_write(stream, asio::buffer(frame.data(), frame.size()),
                              [](const error_code&, std::size_t) {});
            // In TLS 1.3 the refusal of a client's certificate comes after the client is done.
            asio::async_read(stream, asio::buffer(byte),
                             [&](const error_code& late, std::size_t) { said = late; });
        });
        run_until([&] { return said.has_value() || accepted_; });
        EXPECT_FALSE(accepted_);
        return said.value_or(error_code());
    }

    std::filesystem::path folder_;
    asio::io_context io_;
    std::unique_ptr<Listener> listener_;
    std::uint16_t port_ = 0;
    std::unique_ptr<Link> accepted_;
    std::vector<std::uint32_t> received_;
    std::string closed_;
    std::unique_ptr<Connector> connector_;
    std::unique_ptr<Link> connected_;
    std::optional<Error> refusal_;
    std::string answer_;
};

TEST_F(Tls, ConnectsTheTwoThatKnowEachOther) {
    listen(credentials("hand", "coprocessor"));
    connect(TlsAddress{"127.0.0.1", port_, credentials("coprocessor", "hand")});
    run_until([&] { return !received_.empty(); });
    EXPECT_EQ(received_, std::vector<std::uint32_t>{7});
    EXPECT_TRUE(connected_->ordered());
    // A peer that is gone is seen at once.
    connected_.reset();
    run_until([&] { return !closed_.empty(); });
    EXPECT_EQ(closed_, "the peer has closed the link");
}

// A record takes 2^14 bytes, and adds 22 of its own.
TEST_F(Tls, CountsTheRecordsOfWhatItSendsLast) {
    for (const auto& [frame_bytes, line_bytes] : {std::pair{16'384U, 16'406U}, std::pair{16'385U, 16'429U}}) {
        listen(credentials("hand", "coprocessor"));
        connect(TlsAddress{"127.0.0.1", port_, credentials("coprocessor", "hand")});
        received_.clear(), closed_.clear();
        run_until([&] { return !received_.empty(); });
        run_all(io_);
        const std::uint64_t sent = connected_->counts().bytes_out;
        const std::uint64_t heard = accepted_->counts().in.bytes;
        proto::Envelope packet;
        packet.set_position(8);
        FrameWriter writer;
        packet.set_payload(std::string(frame_bytes - 100, 'x'));
        packet.mutable_payload()->append(frame_bytes - writer.stream_frame(packet).size(), 'x');
        ASSERT_EQ(writer.stream_frame(packet).size(), frame_bytes);
        connected_->send(packet);
        connected_->close();
        EXPECT_EQ(connected_->counts().bytes_out - sent, line_bytes);
        run_until([&] { return !closed_.empty(); });
        EXPECT_EQ(accepted_->counts().in.bytes - heard, line_bytes);
        connected_.reset(), accepted_.reset(), listener_.reset();
    }
}

TEST_F(Tls, RefusesACoprocessorWithAnotherCertificate) {
    listen(credentials("hand", "coprocessor"));
    connect(TlsAddress{"127.0.0.1", port_, credentials("stranger", "hand")});
    run_until([&] { return refusal_.has_value() && listener_->refused_peers() > 0; });
    EXPECT_FALSE(accepted_);
}

TEST_F(Tls, RefusesAHandWithAnotherCertificateAtOnce) {
    listen(credentials("stranger", "coprocessor"));
    connect(TlsAddress{"127.0.0.1", port_, credentials("coprocessor", "hand")});
    run_until([&] { return refusal_.has_value(); });
    EXPECT_EQ(refusal_->kind, Error::Kind::not_allowed);
    EXPECT_NE(refusal_->text.find("is not the one that we hold"), std::string::npos) << refusal_->text;
    EXPECT_FALSE(accepted_);
}

TEST_F(Tls, RefusesAPeerWithoutACertificate) {
    listen(credentials("hand", "coprocessor"));
    const auto said = refusal_of_a_stranger([](asio::ssl::context&) {});
    EXPECT_NE(said.message().find("certificate required"), std::string::npos) << said.message();
    ASSERT_FALSE(accepted_);
    run_until([&] { return listener_->refused_peers() == 1; });
}

TEST_F(Tls, TellsAPeerWithAnotherCertificateThatItIsABadOne) {
    listen(credentials("hand", "coprocessor"));
    const auto said = refusal_of_a_stranger([&](asio::ssl::context& context) {
        context.use_certificate_chain_file(crt("stranger").string());
        context.use_private_key_file(key("stranger").string(), asio::ssl::context::pem);
    });
    EXPECT_NE(said.message().find("bad certificate"), std::string::npos) << said.message();
}

TEST_F(Tls, RefusesAnOlderVersion) {
    listen(credentials("hand", "coprocessor"));
    const auto said = refusal_of_a_stranger([&](asio::ssl::context& context) {
        ::SSL_CTX_set_max_proto_version(context.native_handle(), TLS1_2_VERSION);
        context.use_certificate_chain_file(crt("coprocessor").string());
        context.use_private_key_file(key("coprocessor").string(), asio::ssl::context::pem);
    });
    EXPECT_NE(said.message().find("version"), std::string::npos) << said.message();
    ASSERT_FALSE(accepted_);
    run_until([&] { return listener_->refused_peers() == 1; });
}

TEST_F(Tls, TellsAPlainPeerThatTheLinkHasKeys) {
    listen(credentials("hand", "coprocessor"));
    connect(TcpAddress{"127.0.0.1", port_});
    run_until([&] { return !answer_.empty() && listener_->refused_peers() == 1; });
    EXPECT_EQ(answer_, "this link has keys, and your scene has none; give it link.keys");
    EXPECT_FALSE(accepted_);
}

TEST_F(Tls, TellsAPeerWithKeysThatTheLinkHasNone) {
    auto plain = open_listener(io_, TcpAddress{"127.0.0.1", 0});
    ASSERT_TRUE(plain);
    plain.value()->start([&](std::unique_ptr<Link> link) { accepted_ = std::move(link); });
    connect(TlsAddress{"127.0.0.1", std::get<TcpAddress>(plain.value()->address()).port,
                       credentials("coprocessor", "hand")});
    run_until([&] { return refusal_.has_value(); });
    EXPECT_EQ(refusal_->kind, Error::Kind::not_allowed);
    EXPECT_NE(refusal_->text.find("does not speak TLS"), std::string::npos) << refusal_->text;
    EXPECT_FALSE(accepted_);
    EXPECT_FALSE(connected_);
}

// Their refusal comes after the handshake is over for the client.
TEST_F(Tls, TellsACoprocessorForGoodThatItsCertificateIsRefused) {
    listen(credentials("hand", "coprocessor"));
    connect(TlsAddress{"127.0.0.1", port_, credentials("stranger", "hand")});
    run_until([&] { return refusal_.has_value(); });
    EXPECT_EQ(refusal_->kind, Error::Kind::not_allowed);
    EXPECT_NE(refusal_->text.find("does not accept our certificate"), std::string::npos) << refusal_->text;
}

TEST_F(Tls, LetsSilentStrangersWaitWithoutHoldingUpThePeer) {
    listen(credentials("hand", "coprocessor"));
    std::vector<tcp::socket> silent;
    for (int i = 0; i < 20; ++i) {
        silent.emplace_back(io_);
        silent.back().connect({asio::ip::make_address("127.0.0.1"), port_});
    }
    connect(TlsAddress{"127.0.0.1", port_, credentials("coprocessor", "hand")});
    run_until([&] { return !received_.empty(); });
    // They are turned away after a while.
    run_until([&] { return listener_->refused_peers() == 20; });
}

// More than may have a handshake under way at once.
TEST_F(Tls, LetsTheRightOneInThroughACrowdThatOnlyConnects) {
    listen(credentials("hand", "coprocessor"));
    std::vector<tcp::socket> silent;
    for (int i = 0; i < 100; ++i) {
        silent.emplace_back(io_);
        silent.back().connect({asio::ip::make_address("127.0.0.1"), port_});
        io_.restart();
        io_.poll();
    }
    connect(TlsAddress{"127.0.0.1", port_, credentials("coprocessor", "hand")});
    run_until([&] { return !received_.empty() || refusal_; });
    EXPECT_FALSE(received_.empty()) << (refusal_ ? refusal_->text : "");
    EXPECT_GE(listener_->refused_peers(), 36U);
}

TEST_F(Tls, RefusesCredentialsThatCannotBe) {
    const auto refused = [&](const TlsCredentials& with) {
        const auto listener = open_listener(io_, TlsAddress{"127.0.0.1", 0, with});
        EXPECT_FALSE(listener);
        return listener ? std::string() : listener.error().text;
    };
    TlsCredentials other_key = credentials("hand", "coprocessor");
    other_key.private_key = key("stranger");
    EXPECT_NE(refused(other_key).find("is not the key of"), std::string::npos);
    TlsCredentials missing = credentials("hand", "nobody");
    EXPECT_NE(refused(missing).find("nobody.crt: No such file"), std::string::npos);
    std::ofstream(crt("nobody")) << "no certificate";
    EXPECT_NE(refused(missing).find("is not a certificate"), std::string::npos);
    std::filesystem::remove(crt("nobody"));
    ASSERT_EQ(::mkfifo(crt("nobody").c_str(), 0600), 0);
    EXPECT_NE(refused(missing).find("is not a regular file"), std::string::npos);
    ::chmod(key("hand").c_str(), 0640);
    EXPECT_NE(refused(credentials("hand", "coprocessor")).find("chmod 600"), std::string::npos);
}

// The secret of a P-256 key in PKCS #8 is the 32 bytes from the 36th on; the rest is public.
TEST_F(Tls, KeepsItsKeyOutOfCoreDumps) {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the sanitizer keeps what was freed, and the test has made the keys in this process";
#endif
    listen(credentials("hand", "coprocessor"));
    connect(TlsAddress{"127.0.0.1", port_, credentials("coprocessor", "hand")});
    run_until([&] { return !received_.empty(); });
    const DumpedMemory dump;
    for (const char* link_end : {"hand", "coprocessor"}) {
        SecretMemory pem(400);
        ASSERT_TRUE(read_key_file(key(link_end), KeyFile::secret, pem.characters()));
        const std::string_view text(pem.characters().data(), pem.bytes().size());
        const std::size_t begin = text.find('\n') + 1;
        SecretMemory der(138);
        std::size_t size = 0;
        ASSERT_EQ(
            ::sodium_base642bin(der.bytes().data(), 138, text.data() + begin, text.find('-', begin) - begin,
                                "\n", &size, nullptr, sodium_base64_VARIANT_ORIGINAL),
            0);
        ASSERT_EQ(size, 138U);
        EXPECT_FALSE(dump.contains(der.bytes().subspan(36, 32))) << link_end;
        EXPECT_FALSE(dump.contains(pem.bytes().subspan(begin + 48, 43))) << link_end;
    }
}

TEST_F(Tls, WritesItsKeysForTheOwnerAndNotOverOthers) {
    struct stat status {};
    ASSERT_EQ(::stat(key("hand").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600U);
    EXPECT_FALSE(write_certificate("hand", crt("hand"), key("hand")));
}

}  // namespace
}  // namespace afferent
