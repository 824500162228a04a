// Listens on a socket of streams, and accepts one peer after another.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/system/error_code.hpp>
#include <chrono>
#include <memory>
#include <type_traits>
#include <utility>

namespace afferent {

template <class Protocol>
boost::system::error_code listen(typename Protocol::acceptor& acceptor,
                                 const typename Protocol::endpoint& endpoint) {
    boost::system::error_code error;
    acceptor.open(endpoint.protocol(), error);
    if constexpr (std::is_same_v<Protocol, boost::asio::ip::tcp>)
        if (!error) acceptor.set_option(boost::asio::ip::tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(boost::asio::socket_base::max_listen_connections, error);
    return error;
}

// Hands each socket to take(state, socket), until `state->acceptor` is closed, which may happen in there.
// Where a peer cannot be accepted, for want of descriptors as a rule, it goes on waiting, and so would the
// next attempt fail at once: a pause comes first.
template <class State, class Take>
void accept_each(const std::shared_ptr<State>& state, Take take) {
    state->acceptor.async_accept([state, take](const boost::system::error_code& error, auto socket) {
        if (!state->acceptor.is_open()) return;
        if (!error) {
            take(state, std::move(socket));
            return accept_each(state, take);
        }
        constexpr std::chrono::milliseconds pause{50};
        const auto timer = std::make_shared<boost::asio::steady_timer>(state->acceptor.get_executor(), pause);
        timer->async_wait([state, take, timer](const boost::system::error_code&) {
            if (state->acceptor.is_open()) accept_each(state, take);
        });
    });
}

}  // namespace afferent
