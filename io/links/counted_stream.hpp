// A stream that counts the bytes it carries, under whatever secures them. For the transports.
#pragma once

#include <cstdint>
#include <utility>

namespace afferent {

// Must not be moved while an operation is under way. It is its own lowest layer: streams on top of it ask it
// for the counts, and close it.
template <class Next>
class CountedStream {
  public:
    using executor_type = typename Next::executor_type;
    using lowest_layer_type = CountedStream;
    // The argument of shutdown() that ends sending, for sockets and for our other streams.
    static constexpr auto shutdown_send = Next::shutdown_send;

    explicit CountedStream(Next next) : next_(std::move(next)) {}

    executor_type get_executor() { return next_.get_executor(); }
    CountedStream& lowest_layer() { return *this; }
    const CountedStream& lowest_layer() const { return *this; }

    template <class Buffers, class Handler>
    auto async_read_some(const Buffers& buffers, Handler&& handler) {
        return next_.async_read_some(buffers, counting(bytes_in_, std::forward<Handler>(handler)));
    }
    template <class Buffers, class Handler>
    auto async_write_some(const Buffers& buffers, Handler&& handler) {
        return next_.async_write_some(buffers, counting(bytes_out_, std::forward<Handler>(handler)));
    }

    bool is_open() const { return next_.is_open(); }
    template <class Error>
    void shutdown(decltype(shutdown_send) what, Error& error) {
        next_.shutdown(what, error);
    }
    template <class Error>
    void close(Error& error) {
        next_.close(error);
    }

    // Since construction.
    std::uint64_t bytes_in() const noexcept { return bytes_in_; }
    std::uint64_t bytes_out() const noexcept { return bytes_out_; }

  private:
    template <class Handler>
    static auto counting(std::uint64_t& count, Handler&& handler) {
        return
            [&count, handler = std::forward<Handler>(handler)](const auto& error, std::size_t bytes) mutable {
                count += bytes;
                handler(error, bytes);
            };
    }

    Next next_;
    std::uint64_t bytes_in_ = 0;
    std::uint64_t bytes_out_ = 0;
};

}  // namespace afferent
