// A viewer by hand: a socket, and the frames that come out of it.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <utility>

namespace afferent {

// Waits for it; a minute is longer than a busy machine takes for anything.
template <class Condition>
bool comes_to_pass(Condition condition) {
    const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (!condition()) {
        if (std::chrono::steady_clock::now() > limit) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
}

class ViewClient {
  public:
    // `url` as the server has given it.
    explicit ViewClient(const std::string& url) : url_(url) {
        const std::size_t colon = url.rfind(':');
        const std::size_t slash = url.find('/', colon);
        host_ = url.substr(7, slash - 7);
        path_ = url.substr(slash);
        sockaddr_in at{};
        at.sin_family = AF_INET;
        at.sin_port = htons(static_cast<std::uint16_t>(std::stoul(url.substr(colon + 1, slash - colon - 1))));
        at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        // Small, so that one who does not read is noticed soon.
        const int bytes = 4096;
        ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
        const timeval minute{.tv_sec = 60, .tv_usec = 0};
        ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &minute, sizeof minute);
        connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0;
    }
    ~ViewClient() { ::close(socket_); }
    ViewClient(const ViewClient&) = delete;
    ViewClient& operator=(const ViewClient&) = delete;

    bool connected() const noexcept { return connected_; }
    const std::string& host() const noexcept { return host_; }
    const std::string& path() const noexcept { return path_; }

    void send(const std::string& text) const {
        EXPECT_EQ(::send(socket_, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
    }
    // Asks for a file of the page, with these headers after the host's.
    void get(const std::string& file, const std::string& headers = "") const {
        send("GET " + path_ + file + " HTTP/1.1\r\nHost: " + host_ + "\r\n" + headers + "\r\n");
    }
    // Asks for the messages, and returns whether it gets them.
    bool open() {
        get("socket", "Origin: http://" + host_ +
                          "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                          "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n");
        return head().find(" 101 ") != std::string::npos;
    }

    // Up to the empty line.
    std::string head() {
        std::string head;
        while (!head.ends_with("\r\n\r\n")) {
            const auto byte = take(1);
            if (!byte) break;
            head += *byte;
        }
        return head;
    }
    // All that comes until the server closes the connection.
    std::string rest() {
        std::string all;
        while (const auto byte = take(1)) all += *byte;
        return all;
    }
    // The next message; nothing once the server has closed the connection, or says that it will.
    std::optional<std::string> message() {
        const auto begin = take(2);
        if (!begin) return std::nullopt;
        const auto byte = [&](const std::string& bytes, std::size_t i) {
            return static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[i]));
        };
        std::uint64_t size = byte(*begin, 1) & 0x7f;
        const std::size_t more = size == 127 ? 8 : size == 126 ? 2 : 0;
        if (more > 0) {
            const auto length = take(more);
            if (!length) return std::nullopt;
            size = 0;
            for (std::size_t i = 0; i < more; ++i) size = size << 8 | byte(*length, i);
        }
        constexpr std::uint64_t text = 0x1;
        if ((byte(*begin, 0) & 0xf) != text) return std::nullopt;
        return take(size);
    }

  private:
    std::optional<std::string> take(std::size_t count) {
        std::string bytes(count, '\0');
        for (std::size_t had = 0; had < count;) {
            const ssize_t now = ::recv(socket_, bytes.data() + had, count - had, 0);
            if (now <= 0) return std::nullopt;
            had += static_cast<std::size_t>(now);
        }
        return bytes;
    }

    std::string url_;
    std::string host_;
    std::string path_;
    int socket_;
    bool connected_ = false;
};

}  // namespace afferent
