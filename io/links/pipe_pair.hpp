// Two pipes as one stream: bytes are read from one and written to the other. For the transports.
#pragma once

#include <boost/asio/posix/stream_descriptor.hpp>
#include <utility>

namespace afferent {

class PipePair {
  public:
    using executor_type = boost::asio::posix::stream_descriptor::executor_type;
    using lowest_layer_type = PipePair;
    enum Shutdown { shutdown_send };

    PipePair(boost::asio::posix::stream_descriptor in, boost::asio::posix::stream_descriptor out)
        : in_(std::move(in)), out_(std::move(out)) {}

    executor_type get_executor() { return in_.get_executor(); }
    PipePair& lowest_layer() { return *this; }

    template <class Buffers, class Handler>
    auto async_read_some(const Buffers& buffers, Handler&& handler) {
        return in_.async_read_some(buffers, std::forward<Handler>(handler));
    }
    template <class Buffers, class Handler>
    auto async_write_some(const Buffers& buffers, Handler&& handler) {
        return out_.async_write_some(buffers, std::forward<Handler>(handler));
    }

    bool is_open() const { return in_.is_open(); }
    // The peer still reads what has been written, and then the end.
    void shutdown(Shutdown, boost::system::error_code& error) { out_.close(error); }
    void close(boost::system::error_code& error) {
        boost::system::error_code ignored;
        out_.close(ignored);
        in_.close(error);
    }

  private:
    boost::asio::posix::stream_descriptor in_;
    boost::asio::posix::stream_descriptor out_;
};

}  // namespace afferent
