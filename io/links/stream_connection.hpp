// A connection over anything that Asio reads and writes as a stream. For the transports; programs use
// transports.hpp.
#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "afferent/io/links/connection_link.hpp"
#include "afferent/io/links/link.hpp"
#include "afferent/io/links/send_queue.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/message_types.hpp"

namespace afferent {

// Lives as long as an operation of its own is under way. A stream has, besides what Asio asks of one, a
// `lowest_layer()` that can be closed and whose sending can be shut down. Each stream takes seconds to
// compile: there is one for all plain sockets.
template <class Stream>
class StreamConnection final : public Connection,
                               public std::enable_shared_from_this<StreamConnection<Stream>> {
  public:
    StreamConnection(Stream stream, const LinkOptions& options)
        : stream_(std::move(stream)),
          farewell_(stream_.get_executor()),
          queue_(options.queue_bytes, options.lossless) {}

    void start(LinkCallbacks callbacks) override {
        callbacks_ = std::make_shared<const LinkCallbacks>(std::move(callbacks));
        read();
    }

    bool send(const proto::Envelope& message) override {
        if (closing_) return false;
        const auto pushed = queue_.push(writer_.stream_frame(message), message.position() != 0);
        counts_.dropped = queue_.dropped();
        if (pushed == SendQueue::Pushed::overflow) {
            boost::asio::post(stream_.get_executor(), [self = this->shared_from_this()] {
                self->fail({Error::Kind::closed, "the peer does not read what it is sent"});
            });
            return false;
        }
        if (!writing_) write();
        return pushed == SendQueue::Pushed::whole;
    }

    // Silent from now on. What is queued is still sent; then whatever the peer sends is read until it closes
    // as well, because closing with bytes unread would tear down what is still on its way to it.
    void close() override {
        callbacks_.reset();
        closing_ = true;
        farewell_.expires_after(longest_farewell);
        farewell_.async_wait([self = this->shared_from_this()](const boost::system::error_code& error) {
            if (!error) self->shut();
        });
        if (!writing_) end_of_sending();
    }

    void abort() override {
        callbacks_.reset();
        closing_ = true;
        shut();
    }

    std::size_t queued_bytes() const override { return queue_.bytes(); }
    bool ordered() const override { return true; }
    bool lives() const override { return !closing_; }
    const LinkCounts& counts() const override { return counts_; }

  private:
    static constexpr std::size_t bytes_per_write = std::size_t{64} * 1024;
    static constexpr std::chrono::milliseconds longest_farewell{500};

    void read() {
        const std::span<std::byte> space = reader_.space();
        stream_.async_read_some(
            boost::asio::buffer(space.data(), space.size()),
            [self = this->shared_from_this()](const boost::system::error_code& error, std::size_t count) {
                self->has_read(error, count);
            });
    }

    void has_read(const boost::system::error_code& error, std::size_t count) {
        if (error) return fail(error);
        if (!closing_) deliver(count);
        if (stream_.lowest_layer().is_open()) read();
    }

    void deliver(std::size_t count) {
        reader_.filled(count);
        // A callback may close this link and drop the callbacks while they run.
        const auto callbacks = callbacks_;
        while (callbacks_) {
            const Result<bool> next = reader_.next(message_);
            counts_.in = reader_.counts();
            if (!next) {
                if (reader_.lost()) return fail(next.error());
                callbacks->bad_frame(next.error());
            } else if (next.value()) {
                callbacks->message(message_);
            } else {
                return;
            }
        }
    }

    void write() {
        writing_ = true;
        out_.clear();
        queue_.take(out_, bytes_per_write);
        boost::asio::async_write(
            stream_, boost::asio::buffer(out_.data(), out_.size()),
            [self = this->shared_from_this()](const boost::system::error_code& error, std::size_t count) {
                self->has_written(error, count);
            });
    }

    void has_written(const boost::system::error_code& error, std::size_t count) {
        writing_ = false;
        counts_.bytes_out += count;
        if (error) return fail(error);
        if (!queue_.empty())
            write();
        else if (closing_)
            end_of_sending();
    }

    void fail(const boost::system::error_code& error) {
        // A process that is killed takes no leave of TLS either; "asio.ssl.stream" reports that and nothing
        // else.
        const bool gone = error == boost::asio::error::eof ||
                          error.category().name() == std::string_view("asio.ssl.stream");
        fail(Error{Error::Kind::closed, gone ? "the peer has closed the link" : error.message()});
    }

    void fail(const Error& error) {
        const auto callbacks = callbacks_;
        abort();
        if (callbacks) callbacks->closed(error);
    }

    void end_of_sending() {
        using Lowest = typename Stream::lowest_layer_type;
        boost::system::error_code ignored;
        stream_.lowest_layer().shutdown(Lowest::shutdown_send, ignored);
    }

    void shut() {
        boost::system::error_code ignored;
        farewell_.cancel();
        stream_.lowest_layer().close(ignored);
    }

    Stream stream_;
    boost::asio::steady_timer farewell_;
    std::shared_ptr<const LinkCallbacks> callbacks_;
    FrameReader reader_;
    FrameWriter writer_;
    proto::Envelope message_;
    SendQueue queue_;
    std::vector<std::byte> out_;
    bool writing_ = false;
    bool closing_ = false;
    LinkCounts counts_;
};

}  // namespace afferent
