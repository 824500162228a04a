// One direction of a relay: a channel that keeps to the wall clock.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>

#include "afferent/io/links/channel.hpp"

namespace afferent {

class RelayPipe : public std::enable_shared_from_this<RelayPipe> {
  public:
    using Deliver = std::function<void(std::span<const std::byte>)>;

    RelayPipe(boost::asio::io_context& io, const ChannelParameters& parameters, Deliver deliver)
        : timer_(io), channel_(parameters), deliver_(std::move(deliver)) {}

    void send(std::span<const std::byte> frame, std::uint32_t events) {
        if (pulled_) return;
        channel_.send(now(), frame, events);
        pump();
    }

    void pull(bool pulled) { pulled_ = pulled; }
    // Ends deliveries; may be called from one.
    void close() {
        closed_ = true;
        timer_.cancel();
    }

    bool empty() const noexcept { return channel_.empty(); }
    std::size_t waiting_bytes() const noexcept { return channel_.waiting_bytes(); }
    // Whether the source must wait, or drop: otherwise a fast one could fill memory during a long delay.
    bool full() const noexcept {
        return channel_.waiting_bytes() > most_waiting_bytes || channel_.bytes() > most_bytes;
    }
    const ChannelCounts& counts() const noexcept { return channel_.counts(); }

    static constexpr std::size_t most_waiting_bytes = std::size_t{64} * 1024;
    static constexpr std::size_t most_bytes = std::size_t{16} << 20;

  private:
    using Clock = std::chrono::steady_clock;

    TimePoint now() const {
        return scene_start + std::chrono::duration_cast<Duration>(Clock::now() - start_);
    }

    void pump() {
        while (!closed_ && channel_.next_arrival(now())) {
            const auto frame = channel_.arrive();
            if (!pulled_) deliver_(frame);
        }
        const auto next = channel_.next_change();
        if (closed_ || !next) return;
        timer_.expires_at(start_ + (*next - scene_start));
        timer_.async_wait([self = shared_from_this()](const boost::system::error_code& error) {
            if (!error) self->pump();
        });
    }

    Clock::time_point start_ = Clock::now();
    boost::asio::steady_timer timer_;
    Channel channel_;
    Deliver deliver_;
    bool pulled_ = false;
    bool closed_ = false;
};

}  // namespace afferent
