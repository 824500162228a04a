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

#include "afferent/io/links/link.hpp"
#include "afferent/io/links/send_queue.hpp"
#include "afferent/io/links/stream_peer.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/message_types.hpp"

namespace afferent {

// How many bytes on the line these bytes take: as many, where nothing secures them. Secured streams have an
// overload.
template <class Stream>
std::uint64_t line_bytes(const Stream&, std::uint64_t bytes) {
    return bytes;
}

inline SendQueue::Kind kind_of(const proto::Envelope& message) noexcept {
    if (!is_packet(message)) return SendQueue::Kind::message;
    // Without a position it begins where the packet before it ended.
    return message.position() == 0 ? SendQueue::Kind::follower : SendQueue::Kind::packet;
}

// Lives as long as an operation of its own is under way. The stream's `lowest_layer()` is a CountedStream.
// Each stream takes seconds to compile: there is one for all plain sockets.
template <class Stream>
class StreamConnection final : public StreamPeer,
                               public std::enable_shared_from_this<StreamConnection<Stream>> {
  public:
    StreamConnection(Stream stream, const LinkOptions& options)
        : stream_(std::move(stream)),
          farewell_(stream_.get_executor()),
          queue_(options.queue_bytes, options.lossless) {}

    void await_first(OnFirst on_first) override {
        on_first_ = std::move(on_first);
        read();
    }

    void start(LinkCallbacks callbacks) override {
        callbacks_ = std::make_shared<const LinkCallbacks>(std::move(callbacks));
        reader_.reserve();
        if (!std::exchange(holds_first_, false)) return read();
        boost::asio::post(stream_.get_executor(), [self = this->shared_from_this()] {
            if (const auto kept = self->callbacks_) kept->message(self->message_);
            self->deliver();
        });
    }

    bool send(const proto::Envelope& message) override {
        if (closing_) return false;
        const auto pushed = queue_.push(writer_.stream_frame(message), kind_of(message));
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

    // No more callbacks. What is queued is still sent, but is counted at once, because nobody asks later.
    // After that, everything the peer sends is read until it closes as well: closing with unread bytes would
    // destroy what is still on its way to it.
    void close() override {
        callbacks_.reset();
        on_first_ = nullptr;
        counts_.bytes_out =
            (writing_ ? sent_before_ + line_bytes(stream_, out_.size()) : line().bytes_out()) +
            line_bytes(stream_, queue_.bytes());
        closing_ = true;
        farewell_.expires_after(longest_farewell);
        farewell_.async_wait([self = this->shared_from_this()](const boost::system::error_code& error) {
            if (!error) self->shut();
        });
        if (!writing_) end_of_sending();
        if (!reading_ && line().is_open()) read();
    }

    void abort() override {
        callbacks_.reset();
        on_first_ = nullptr;
        closing_ = true;
        shut();
    }

    void give_way(const Error& reason) override { fail(reason); }

    std::size_t queued_bytes() const override { return queue_.bytes(); }
    bool ordered() const override { return true; }
    bool lives() const override { return !closing_; }
    const LinkCounts& counts() const override { return counts_; }
    std::chrono::steady_clock::time_point last_heard() const override { return last_heard_; }

  private:
    static constexpr std::size_t bytes_per_write = std::size_t{64} * 1024;
    static constexpr std::chrono::milliseconds longest_farewell{500};
    // After so many frames others have their turn, however many are there.
    static constexpr int frames_per_turn = 64;

    auto& line() { return stream_.lowest_layer(); }

    void read() {
        reading_ = true;
        const std::span<std::byte> space = reader_.space();
        stream_.async_read_some(
            boost::asio::buffer(space.data(), space.size()),
            [self = this->shared_from_this()](const boost::system::error_code& error, std::size_t count) {
                self->has_read(error, count);
            });
    }

    void has_read(const boost::system::error_code& error, std::size_t count) {
        reading_ = false;
        if (error) return fail(error);
        if (closing_) return read();  // what comes now is discarded
        reader_.filled(count);
        counts_.in.bytes = line().bytes_in();
        deliver();
    }

    void deliver() {
        if (on_first_) return deliver_first();
        // A callback may close this link and drop the callbacks while they run.
        const auto callbacks = callbacks_;
        for (int i = 0; i < frames_per_turn && callbacks_; ++i) {
            const Result<bool> next = read_frame();
            if (!next) {
                if (reader_.lost()) return fail(next.error());
                callbacks->bad_frame(next.error());
            } else if (next.value()) {
                callbacks->message(message_);
            } else {
                return read();
            }
        }
        if (callbacks_)
            boost::asio::post(stream_.get_executor(), [self = this->shared_from_this()] { self->deliver(); });
    }

    void deliver_first() {
        const Result<bool> next = read_frame();
        if (next && !next.value()) return read();
        holds_first_ = next.has_value();
        const auto on_first = std::exchange(on_first_, nullptr);
        if (next)
            on_first(&message_);
        else
            on_first(next.error());
    }

    Result<bool> read_frame() {
        Result<bool> next = reader_.next(message_);
        const std::uint64_t on_the_line = counts_.in.bytes;
        counts_.in = reader_.counts();
        counts_.in.bytes = on_the_line;
        if (next && next.value()) last_heard_ = std::chrono::steady_clock::now();
        return next;
    }

    void write() {
        writing_ = true;
        sent_before_ = line().bytes_out();
        out_.clear();
        queue_.take(out_, bytes_per_write);
        boost::asio::async_write(
            stream_, boost::asio::buffer(out_.data(), out_.size()),
            [self = this->shared_from_this()](const boost::system::error_code& error, std::size_t) {
                self->has_written(error);
            });
    }

    void has_written(const boost::system::error_code& error) {
        writing_ = false;
        if (!closing_) counts_.bytes_out = line().bytes_out();
        if (error) return fail(error);
        if (!queue_.empty())
            write();
        else if (closing_)
            end_of_sending();
    }

    void fail(const boost::system::error_code& error) {
        // A killed process does not close TLS properly either; then the category is "asio.ssl.stream".
        // "asio.ssl" is a refusal by TLS itself, which in TLS 1.3 comes after the handshake.
        const std::string_view category = error.category().name();
        if (error == boost::asio::error::eof || category == "asio.ssl.stream")
            return fail(Error{Error::Kind::closed, "the peer has closed the link"});
        if (category == "asio.ssl")
            return fail(Error{Error::Kind::not_allowed,
                              "the peer does not accept our certificate: " + error.message()});
        fail(Error{Error::Kind::closed, error.message()});
    }

    void fail(const Error& error) {
        const auto callbacks = callbacks_;
        const auto on_first = std::exchange(on_first_, nullptr);
        abort();
        if (on_first) on_first(error);
        if (callbacks) callbacks->closed(error);
    }

    void end_of_sending() {
        boost::system::error_code ignored;
        line().shutdown(line().shutdown_send, ignored);
    }

    void shut() {
        boost::system::error_code ignored;
        farewell_.cancel();
        line().close(ignored);
    }

    Stream stream_;
    boost::asio::steady_timer farewell_;
    OnFirst on_first_;          // while the first message is waited for
    bool holds_first_ = false;  // it is in message_, and start() is still to come
    std::shared_ptr<const LinkCallbacks> callbacks_;
    FrameReader reader_;
    FrameWriter writer_;
    proto::Envelope message_;
    std::chrono::steady_clock::time_point last_heard_{};
    SendQueue queue_;
    std::vector<std::byte> out_;
    std::uint64_t sent_before_ = 0;  // on the line, before what is being written
    bool reading_ = false;
    bool writing_ = false;
    bool closing_ = false;
    LinkCounts counts_;
};

}  // namespace afferent
