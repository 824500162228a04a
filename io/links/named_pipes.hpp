// Links over a pair of named pipes, between two processes of one user.
#pragma once

#include <memory>
#include <string>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/wire/result.hpp"

namespace afferent {

class Connector;
class Listener;
struct LinkOptions;
struct Patience;

// <path>.in carries bytes to the listener, <path>.out those from it.
struct PipesAddress {
    std::string path;

    std::string text() const { return "pipes:" + path; }
};

// The listener makes the pipes, readable and writable by its own user alone, and removes them at its end if
// they are still its own. Each peer gets a pair of its own, so that none reads what another has left behind.
// Pipes that no listener holds any more are replaced. Errors: `not_allowed` where something else is at the
// path, or another listener.
Result<std::unique_ptr<Listener>> listen_on(boost::asio::io_context& io, const PipesAddress& address,
                                            const LinkOptions& options);

std::unique_ptr<Connector> connector_to(boost::asio::io_context& io, const PipesAddress& address,
                                        const Patience& patience, const LinkOptions& options);

}  // namespace afferent
