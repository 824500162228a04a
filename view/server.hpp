// Serves the page of a view and its messages, on a thread of its own, to browsers on this machine.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "afferent/runtime/result.hpp"

namespace afferent {

// A message; one that begins a course of the scene is never dropped, and makes those before it needless.
struct ViewMessage {
    std::string text;
    bool begins_course = false;
};

// Listens on 127.0.0.1 alone, and reads nothing from a viewer after its request: one that sends something is
// disconnected. Viewers that are slow lose the oldest of what waits for them.
class ViewServer {
  public:
    struct Limits {
        std::size_t viewers = 8;
        // That are being made or answered, of those with the token and of those without it each: the oldest
        // makes way for the next.
        std::size_t requests = 64;
        std::size_t header_bytes = 8192;
        std::chrono::milliseconds for_a_request{5'000};
        std::chrono::milliseconds for_a_sign_of_life{30'000};
        std::size_t waiting_messages = 256;  // of one viewer
        std::size_t waiting_bytes = 4 << 20;
        std::chrono::milliseconds between_messages{40};
        std::chrono::milliseconds for_the_last_messages{500};
    };
    // Both are called on the server's thread.
    struct Source {
        // The first message to a viewer.
        std::function<std::string()> greeting;
        // What there is to tell all viewers: asked for every 40 ms, and a last time at the end.
        std::function<std::vector<ViewMessage>(bool last)> news;
    };

    // Port 0: any free one. Error: `unreachable`.
    static Result<std::unique_ptr<ViewServer>> open(const std::string& token, std::uint16_t port,
                                                    const Limits& limits, Source source);
    // Tells the viewers the last news, and ends within half a second whatever they do.
    ~ViewServer();
    ViewServer(const ViewServer&) = delete;
    ViewServer& operator=(const ViewServer&) = delete;

    std::string url() const;
    std::uint16_t port() const;
    // For any thread.
    struct Counts {
        std::size_t viewers = 0;
        std::size_t connections = 0;
        std::uint64_t dropped_messages = 0;
        std::size_t waiting_bytes = 0;  // of all viewers
    };
    Counts counts() const noexcept;

  private:
    struct State;
    explicit ViewServer(std::unique_ptr<State> state);

    std::unique_ptr<State> state_;
};

}  // namespace afferent
