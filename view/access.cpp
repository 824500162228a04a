#include "afferent/view/access.hpp"

#include <algorithm>
#include <utility>

#include "afferent/view/token.hpp"

namespace afferent {
namespace {

constexpr unsigned bad_request = 400;
constexpr unsigned forbidden = 403;
constexpr unsigned not_found = 404;
constexpr unsigned method_not_allowed = 405;
constexpr unsigned upgrade_required = 426;

}  // namespace

ViewAccess::ViewAccess(std::string token, std::uint16_t port)
    : token_(std::move(token)), port_(std::to_string(port)) {}

ViewAccess::Answer ViewAccess::operator()(const ViewRequest& request) const {
    if (request.hosts.size() != 1 || request.origins.size() > 1) return {.status = bad_request};
    const std::string_view host = request.hosts.front();
    if (host != "127.0.0.1:" + port_ && host != "localhost:" + port_) return {.status = forbidden};
    if (!request.origins.empty() && request.origins.front() != "http://" + std::string(host))
        return {.status = forbidden};
    if (request.method != "GET") return {.status = method_not_allowed};

    std::string_view rest = request.target;
    if (!rest.starts_with('/')) return {.status = bad_request};
    rest.remove_prefix(1);
    const std::size_t slash = rest.find('/');
    if (slash == std::string_view::npos || !same_token(token_, rest.substr(0, slash)))
        return {.status = not_found};
    rest.remove_prefix(slash + 1);
    if (rest == "socket") {
        if (!request.upgrades) return {.status = upgrade_required};
        // Whatever is not a browser's page has no business here.
        if (request.origins.empty()) return {.status = forbidden};
        return {.is_socket = true};
    }
    if (request.upgrades) return {.status = bad_request};
    return {.file = rest.empty() ? "index.html" : rest};
}

bool is_unambiguous(std::string_view head) {
    static constexpr std::string_view host = "host:";
    static constexpr std::string_view blank = " \t";
    while (!head.empty()) {
        const std::size_t end = std::min(head.find("\r\n"), head.size());
        std::string_view line = head.substr(0, end);
        head.remove_prefix(std::min(end + 2, head.size()));
        if (line.find_first_of(blank) == 0) return false;
        if (!std::ranges::equal(line.substr(0, host.size()), host,
                                [](char one, char lower) { return (one | 0x20) == lower; }))
            continue;
        line.remove_prefix(std::min(line.find_first_not_of(blank, host.size()), line.size()));
        if (line.find_first_of(" \t\r\n") != std::string_view::npos) return false;
    }
    return true;
}

std::string content_policy(std::string_view host) {
    return "default-src 'none'; script-src 'self'; style-src 'self'; connect-src ws://" + std::string(host) +
           "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
}

}  // namespace afferent
