// Those who attack a hand from this machine, over real sockets.
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>

#include "afferent/io/links/link_address.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent::bench {

// Where a hand listens. Anybody can reach it; `coprocessor` has the keys of its coprocessor as well, where
// there are any.
struct Victim {
    const Plan& plan;
    std::string unix_path;   // empty: it is at a port of 127.0.0.1
    std::uint16_t port = 0;  // of TCP, or of UDP
    LinkAddress coprocessor;
};

// Each goes on until it is asked to stop, and returns how often it has done what it does.

// Connects and hangs up, as fast as can be.
std::uint64_t connect_and_hang_up(const Victim& victim, const std::stop_token& stop);
// Connects, opens a TLS handshake, and leaves it to the hand to wait for the rest; as fast as can be.
std::uint64_t begin_handshakes(const Victim& victim, const std::stop_token& stop);
// Connects as often as `count`, then says nothing.
std::uint64_t hold_idle_connections(const Victim& victim, std::uint64_t count, const std::stop_token& stop);
// Sends datagrams of any content.
std::uint64_t send_datagrams(const Victim& victim, std::size_t bytes, double per_s,
                             const std::stop_token& stop);

// Sends the hellos of DTLS clients that nobody knows, from addresses of this machine's that are not the
// coprocessor's, and never returns a cookie.
std::uint64_t send_hellos(const Victim& victim, double per_s, const std::stop_token& stop);
// Returns the cookie, and leaves it to the hand to wait for the rest; as fast as can be.
std::uint64_t return_cookies(const Victim& victim, const std::stop_token& stop);

// Plays the coprocessor, keys included: opens sessions and sends clocks in them, as fast as they are taken.
std::uint64_t send_clocks(const Victim& victim, const std::stop_token& stop);
// Opens a session and says that the scene has ended, again and again.
std::uint64_t open_and_say_bye(const Victim& victim, const std::stop_token& stop);
// Says so without having said hello.
std::uint64_t say_bye_first(const Victim& victim, const std::stop_token& stop);

}  // namespace afferent::bench
