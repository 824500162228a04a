// Access to a view: what an HTTP request must be for the page, its files or its data to be given.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace afferent {

// The parts of a request that the decision depends on.
struct ViewRequest {
    std::string_view method;
    std::string_view target;
    // Every header of that name: one that is there twice is refused.
    std::vector<std::string_view> hosts;
    std::vector<std::string_view> origins;
    bool upgrades = false;  // to a WebSocket
};

// The request's host has to be this machine's loopback by one of two names, with the port: a page of another
// name that the browser takes for this address (DNS rebinding) is refused. The origin, which a browser states
// where a page's script asks, has to be the same. The target begins with the token.
class ViewAccess {
  public:
    ViewAccess(std::string token, std::uint16_t port);

    // The name of the file that is asked for ("index.html" for the page itself), or the status to answer
    // with.
    struct Answer {
        unsigned status = 200;
        std::string_view file = {};
        bool is_socket = false;
    };
    Answer operator()(const ViewRequest& request) const;

    // The page's address.
    std::string url() const { return "http://127.0.0.1:" + port_ + "/" + token_ + "/"; }

  private:
    std::string token_;
    std::string port_;
};

// Whether whitespace leaves no doubt of what a request asks for: no line is continued on the next, and none
// surrounds the host's name but what follows its colon. `head` is everything up to the empty line.
bool is_unambiguous(std::string_view head);

// The headers that go with every answer, for the host that was asked.
std::string content_policy(std::string_view host);

}  // namespace afferent
