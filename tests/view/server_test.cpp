#include "afferent/view/server.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <vector>

#include "afferent/view/token.hpp"
#include "tests/value_or_throw.hpp"
#include "tests/view/client.hpp"

namespace afferent {
namespace {

const std::string secret = "00112233445566778899aabbccddeeff";

// A server that tells what it is given.
class Told {
  public:
    explicit Told(const ViewServer::Limits& limits = quick()) {
        server = value_or_throw(ViewServer::open(secret, 0, limits,
                                                 {.greeting = [] { return std::string("greeting"); },
                                                  .news = [this](bool last) { return take(last); }}));
    }
    static ViewServer::Limits quick() {
        ViewServer::Limits limits;
        limits.between_messages = std::chrono::milliseconds(1);
        return limits;
    }

    void tell(std::string text, bool begins_course = false) {
        const std::scoped_lock lock(mutex_);
        messages_.push_back({std::move(text), begins_course});
    }
    bool all_taken() {
        const std::scoped_lock lock(mutex_);
        return messages_.empty();
    }

  private:
    std::vector<ViewMessage> take(bool last) {
        const std::scoped_lock lock(mutex_);
        auto taken = std::exchange(messages_, {});
        if (last) taken.push_back({"end"});
        return taken;
    }

    std::mutex mutex_;
    std::vector<ViewMessage> messages_;

  public:
    // Its thread takes the messages.
    std::unique_ptr<ViewServer> server;
};

TEST(ViewServer, ServesThePageAndItsFiles) {
    const Told told;
    for (const auto& [file, type, content] : {std::tuple("", "text/html", "<title>Afferent</title>"),
                                              std::tuple("view.js", "text/javascript", "connect()"),
                                              std::tuple("model.js", "text/javascript", "class Model"),
                                              std::tuple("view.css", "text/css", "--estimate"),
                                              std::tuple("uplot.js", "text/javascript", "uPlot"),
                                              std::tuple("uplot.css", "text/css", ".uplot")}) {
        ViewClient client(told.server->url());
        client.get(file);
        const std::string head = client.head();
        EXPECT_TRUE(head.starts_with("HTTP/1.1 200 ")) << head;
        for (const std::string& header :
             {"Content-Type: " + std::string(type), std::string("X-Content-Type-Options: nosniff"),
              std::string("Referrer-Policy: no-referrer"), std::string("Cache-Control: no-store"),
              std::string("Content-Security-Policy: default-src 'none'; script-src 'self'")})
            EXPECT_NE(head.find(header), std::string::npos) << header << '\n' << head;
        EXPECT_NE(client.rest().find(content), std::string::npos) << file;
    }
}

TEST(ViewServer, ListensOnTheLoopbackAlone) {
    const Told told;
    EXPECT_EQ(told.server->url(),
              "http://127.0.0.1:" + std::to_string(told.server->port()) + "/" + secret + "/");
    // Everything but the loopback is refused: by any of this machine's own addresses, 127.0.0.2 among them.
    for (const char* address : {"127.0.0.2", "127.1.2.3"}) {
        sockaddr_in at{};
        at.sin_family = AF_INET;
        at.sin_port = htons(told.server->port());
        ::inet_pton(AF_INET, address, &at.sin_addr);
        const int other = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        EXPECT_NE(::connect(other, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0) << address;
        ::close(other);
    }
}

TEST(ViewServer, RefusesOthersWithoutAWordOfWhatItIs) {
    const Told told;
    const std::string& url = told.server->url();
    const std::string host = "127.0.0.1:" + std::to_string(told.server->port());
    struct Case {
        std::string request;
        const char* status;
    };
    const std::string page = "/" + secret + "/";
    const std::vector<Case> cases{
        {"GET " + page + " HTTP/1.1\r\nHost: evil.example\r\n\r\n", " 403 "},
        {"GET " + page + " HTTP/1.1\r\nHost: " + host + "\r\nHost: evil.example\r\n\r\n", " 400 "},
        {"GET " + page + " HTTP/1.1\r\nHost: " + host + "\r\nOrigin: http://evil.example\r\n\r\n", " 403 "},
        {"GET " + page + "passwd HTTP/1.1\r\nHost: " + host + "\r\n\r\n", " 404 "},
        {"GET " + page + "../../etc/passwd HTTP/1.1\r\nHost: " + host + "\r\n\r\n", " 404 "},
        {"GET " + page + " HTTP/1.1\r\nHost: " + host + " \r\n\r\n", " 400 "},
        {"GET " + page + " HTTP/1.1\r\nHost: " + host + "\r\n \r\n\r\n", " 400 "},
        {"GET / HTTP/1.1\r\nHost: " + host + "\r\n\r\n", " 404 "},
        {"OPTIONS " + page + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n", " 405 "},
        {"GET " + page + "socket HTTP/1.1\r\nHost: " + host +
             "\r\nOrigin: http://evil.example\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
             "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n",
         " 403 "},
    };
    for (const Case& each : cases) {
        ViewClient client(url);
        client.send(each.request);
        const std::string answer = client.rest();
        EXPECT_NE(answer.substr(0, answer.find('\n')).find(each.status), std::string::npos)
            << each.request << answer;
        EXPECT_EQ(answer.find(secret), std::string::npos) << answer;
        EXPECT_EQ(answer.find("evil.example"), std::string::npos) << answer;
    }
}

TEST(ViewServer, ClosesOnRequestsThatAreNone) {
    const Told told;
    const std::vector<std::string> requests{
        "nonsense\r\n\r\n",
        "GET / HTTP/1.1\r\nHost: " + std::string(20'000, 'a'),
        "GET / HTTP/1.1\r\nHost: a\r\nContent-Length: 10\r\n\r\n0123456789",
        std::string(64, '\0'),
    };
    for (const std::string& request : requests) {
        ViewClient client(told.server->url());
        client.send(request);
        EXPECT_EQ(client.rest().find(" 200 "), std::string::npos);
    }
    EXPECT_TRUE(comes_to_pass([&] { return told.server->counts().connections == 0; }));
}

TEST(ViewServer, GivesARequestItsTime) {
    ViewServer::Limits limits = Told::quick();
    limits.for_a_request = std::chrono::milliseconds(50);
    const Told told(limits);
    ViewClient silent(told.server->url());
    ViewClient slow(told.server->url());
    slow.send("GET / HT");
    EXPECT_EQ(silent.rest(), "");
    EXPECT_EQ(slow.rest(), "");
    EXPECT_TRUE(comes_to_pass([&] { return told.server->counts().connections == 0; }));
}

TEST(ViewServer, TellsEveryViewerWhatThereIsAndSaysWhenItEnds) {
    Told told;
    ViewClient one(told.server->url());
    ViewClient two(told.server->url());
    for (ViewClient* client : {&one, &two}) {
        ASSERT_TRUE(client->open());
        EXPECT_EQ(client->message(), "greeting");
    }
    told.tell("first");
    told.tell("second");
    for (ViewClient* client : {&one, &two}) {
        EXPECT_EQ(client->message(), "first");
        EXPECT_EQ(client->message(), "second");
    }
    told.server.reset();
    for (ViewClient* client : {&one, &two}) {
        EXPECT_EQ(client->message(), "end");
        EXPECT_EQ(client->message(), std::nullopt);
    }
}

TEST(ViewServer, DropsTheOldestForAViewerThatDoesNotReadAndCounts) {
    ViewServer::Limits limits = Told::quick();
    limits.waiting_messages = 10;
    Told told(limits);
    ViewClient stopped(told.server->url());
    ViewClient reading(told.server->url());
    for (ViewClient* client : {&stopped, &reading}) {
        ASSERT_TRUE(client->open());
        EXPECT_EQ(client->message(), "greeting");
    }
    // As much as the system may hold back for it, and more.
    constexpr int messages = 200;
    for (int i = 0; i < messages; ++i) {
        const std::string text = std::to_string(i) + std::string(100'000, '.');
        told.tell(text);
        // Whoever reads gets everything, at once, whatever the other does.
        EXPECT_EQ(reading.message(), text);
    }
    const std::uint64_t dropped = told.server->counts().dropped_messages;
    EXPECT_GT(dropped, messages / 2U);
    EXPECT_LE(told.server->counts().waiting_bytes, 11 * 100'010U);

    // It reads again: what the system had, how many were dropped, and the newest.
    std::vector<std::string> got;
    std::string said;
    while (got.empty() || !got.back().starts_with(std::to_string(messages - 1) + ".")) {
        auto message = stopped.message();
        ASSERT_TRUE(message);
        if (message->starts_with('{'))
            said = *message;
        else
            got.push_back(*std::move(message));
    }
    EXPECT_EQ(got.size() + dropped, messages + 0U);
    EXPECT_EQ(said, "{\"kind\":\"dropped\",\"messages\":" + std::to_string(dropped) + "}");
    for (std::size_t i = 1; i < got.size(); ++i) EXPECT_LT(std::stoi(got[i - 1]), std::stoi(got[i]));
}

TEST(ViewServer, NeverDropsWhatBeginsACourse) {
    ViewServer::Limits limits = Told::quick();
    limits.waiting_messages = 3;
    Told told(limits);
    ViewClient stopped(told.server->url());
    ASSERT_TRUE(stopped.open());
    for (int i = 0; i < 50; ++i) told.tell("old" + std::string(100'000, '.'));
    ASSERT_TRUE(
        comes_to_pass([&] { return told.all_taken() && told.server->counts().dropped_messages > 10; }));
    told.tell("course", true);
    for (int i = 0; i < 50; ++i) told.tell("new" + std::string(100'000, '.'));
    told.tell("last");
    bool begun = false;
    for (std::string message; message != "last";) {
        const auto next = stopped.message();
        ASSERT_TRUE(next);
        message = *next;
        if (message.starts_with("new")) {
            EXPECT_TRUE(begun);
        }
        if (message.starts_with("old")) {
            EXPECT_FALSE(begun);
        }
        begun |= message == "course";
    }
    EXPECT_TRUE(begun);
}

TEST(ViewServer, DisconnectsAViewerThatSendsSomething) {
    ViewServer::Limits limits = Told::quick();
    limits.for_a_sign_of_life = std::chrono::seconds(1);
    Told told(limits);
    ViewClient client(told.server->url());
    ASSERT_TRUE(client.open());
    EXPECT_EQ(client.message(), "greeting");
    client.send(std::string("\x81\x85\x00\x00\x00\x00hello", 11));  // a text, masked by zero
    EXPECT_EQ(client.message(), std::nullopt);
    EXPECT_TRUE(comes_to_pass([&] { return told.server->counts().viewers == 0; }));

    ViewClient liar(told.server->url());
    ASSERT_TRUE(liar.open());
    EXPECT_EQ(liar.message(), "greeting");
    liar.send(std::string("\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff", 10));  // of 2^63 bytes, it says
    EXPECT_EQ(liar.message(), std::nullopt);
    EXPECT_TRUE(comes_to_pass([&] { return told.server->counts().viewers == 0; }));
}

TEST(ViewServer, ForgetsAViewerThatGivesNoSignOfLife) {
    ViewServer::Limits limits = Told::quick();
    limits.for_a_sign_of_life = std::chrono::milliseconds(50);
    Told told(limits);
    ViewClient stopped(told.server->url());
    ASSERT_TRUE(stopped.open());
    ASSERT_TRUE(comes_to_pass([&] { return told.server->counts().viewers == 0; }));
}

TEST(ViewServer, TakesAsManyViewersAsItMayAndNoMore) {
    ViewServer::Limits limits = Told::quick();
    limits.viewers = 2;
    Told told(limits);
    std::optional<ViewClient> one(told.server->url());
    ViewClient two(told.server->url());
    ASSERT_TRUE(one->open());
    ASSERT_TRUE(two.open());
    {
        ViewClient three(told.server->url());
        three.get("socket",
                  "Origin: http://" + three.host() +
                      "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                      "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n");
        EXPECT_NE(three.head().find(" 503 "), std::string::npos);
    }
    ASSERT_TRUE(comes_to_pass([&] { return told.server->counts().connections == 2; }));
    one.reset();
    ASSERT_TRUE(comes_to_pass([&] { return told.server->counts().viewers == 1; }));
    ViewClient next(told.server->url());
    EXPECT_TRUE(next.open());
}

TEST(ViewServer, GivesThePageHoweverManyOthersAreConnected) {
    ViewServer::Limits limits = Told::quick();
    limits.for_a_request = std::chrono::minutes(1);
    Told told(limits);
    ViewClient viewer(told.server->url());
    ASSERT_TRUE(viewer.open());
    EXPECT_EQ(viewer.message(), "greeting");
    // A third of them says nothing, a third is slow, and a third does not take its answer.
    std::vector<std::unique_ptr<ViewClient>> others;
    for (int i = 0; i < 630; ++i) {
        others.push_back(std::make_unique<ViewClient>(told.server->url()));
        ASSERT_TRUE(others.back()->connected());
        if (i % 3 == 1) others.back()->send("GET / HT");
        if (i % 3 == 2) others.back()->send("GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n");
    }
    ViewClient owner(told.server->url());
    owner.get("");
    EXPECT_TRUE(owner.head().starts_with("HTTP/1.1 200 "));
    ViewClient next(told.server->url());
    EXPECT_TRUE(next.open());
    EXPECT_LE(told.server->counts().connections, 2 * limits.requests + limits.viewers);
    // The oldest have made way, and viewers have not.
    EXPECT_EQ(others.front()->rest(), "");
    told.tell("news");
    EXPECT_EQ(viewer.message(), "news");
}

TEST(ViewServer, EndsWhateverItsViewersDo) {
    ViewServer::Limits limits = Told::quick();
    limits.for_the_last_messages = std::chrono::milliseconds(20);
    Told told(limits);
    ViewClient stopped(told.server->url());
    ASSERT_TRUE(stopped.open());
    ViewClient unsaid(told.server->url());
    ViewClient half(told.server->url());
    half.send("GET / HTTP");
    for (int i = 0; i < 100; ++i) told.tell(std::string(100'000, '.'));
    ASSERT_TRUE(comes_to_pass([&] { return told.all_taken(); }));
    EXPECT_GT(told.server->counts().waiting_bytes, 0U);
    told.server.reset();  // ctest would end a test that hangs here
    // Another can take the port at once.
    EXPECT_EQ(stopped.message(), "greeting");
}

TEST(ViewServer, SaysWhereThePortIsTaken) {
    const Told told;
    const auto second = ViewServer::open(secret, told.server->port(), {}, {});
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().text.find("port " + std::to_string(told.server->port())), std::string::npos);
    EXPECT_NE(second.error().text.find("in use"), std::string::npos) << second.error().text;
}

}  // namespace
}  // namespace afferent
