#include "afferent/io/links/datagram_connection.hpp"

#include <boost/asio/post.hpp>
#include <string>
#include <utility>

namespace afferent {
namespace {

// Messages that a later one supersedes: not hellos, their answers, and byes.
bool may_be_dropped(const proto::Envelope& message) {
    return is_packet(message) || message.has_samples() || message.has_status();
}

}  // namespace

DatagramConnection::DatagramConnection(boost::asio::io_context& io, std::shared_ptr<DatagramPort> port,
                                       const DatagramPeer& peer, DatagramCodec codec,
                                       const LinkOptions& options, std::shared_ptr<void> owner)
    : port_(std::move(port)),
      line_(port_->line()),
      peer_(peer),
      codec_(std::move(codec)),
      silence_limit_(options.silence_limit),
      owner_(std::move(owner)),
      timer_(io),
      queue_(options.queue_bytes),
      heard_(Clock::now()),
      told_(heard_) {}

void DatagramConnection::start(LinkCallbacks callbacks) {
    callbacks_ = std::make_shared<const LinkCallbacks>(std::move(callbacks));
    look_after();
    if (first_)
        boost::asio::post(timer_.get_executor(),
                          [self = shared_from_this(), first = std::move(*first_)] { self->deliver(first); });
    first_.reset();
}

DatagramCodec::Unwrapped DatagramConnection::receive(const DatagramPeer& from,
                                                     std::span<const std::byte> datagram) {
    const DatagramCodec::Unwrapped how = codec_.unwrap(datagram, opened_, Clock::now());
    if (how == DatagramCodec::Unwrapped::good) peer_ = from;
    if (!is_taken(how)) return how;
    // deliver() counts the frame.
    counts_.in.bytes += line_.bytes_of(datagram) - opened_.size();
    deliver(opened_);
    return how;
}

void DatagramConnection::receive_first(std::vector<std::byte> frame, std::span<const std::byte> datagram) {
    counts_.in.bytes += line_.bytes_of(datagram) - frame.size();
    first_ = std::move(frame);
}

void DatagramConnection::count(DatagramCodec::Unwrapped how, std::span<const std::byte> datagram) {
    if (how == DatagramCodec::Unwrapped::forged) ++counts_.in.forged;
    if (how != DatagramCodec::Unwrapped::repeated) return;
    counts_.in.bytes += line_.bytes_of(datagram);
    ++counts_.in.repeated;
}

void DatagramConnection::deliver(std::span<const std::byte> frame) {
    // A callback may close this link and drop the callbacks while they run.
    const auto callbacks = callbacks_;
    if (!callbacks) return;
    if (frame.empty()) {
        heard_ = Clock::now();
    } else if (const Result<void> read = read_datagram(frame, message_, counts_.in); !read) {
        callbacks->bad_frame(read.error());
    } else {
        heard_ = Clock::now();
        callbacks->message(message_);
    }
}

bool DatagramConnection::send(const proto::Envelope& message) {
    if (closing_) return false;
    const auto frame = writer_.datagram(message);
    if (frame.size() > max_datagram_frame_bytes) {
        boost::asio::post(timer_.get_executor(), [self = shared_from_this(), size = frame.size()] {
            self->fail({Error::Kind::not_allowed,
                        "a message of " + std::to_string(size) + " bytes is more than the " +
                            std::to_string(max_datagram_frame_bytes) + " that a datagram holds"});
        });
        return false;
    }
    const auto pushed =
        queue_.push(frame, may_be_dropped(message) ? SendQueue::Kind::packet : SendQueue::Kind::message);
    counts_.dropped = queue_.dropped();
    if (pushed == SendQueue::Pushed::overflow) {
        boost::asio::post(timer_.get_executor(), [self = shared_from_this()] {
            self->fail({Error::Kind::closed, "the link is too slow for what it is given"});
        });
        return false;
    }
    write();
    return pushed == SendQueue::Pushed::whole;
}

void DatagramConnection::write() {
    // The port may still call after the connection has released it.
    while (port_ && has_datagram()) {
        unsent_ = port_->send(peer_, datagram_) == 0;
        if (unsent_) return;
        told_ = Clock::now();
    }
    if (closing_) release();
}

bool DatagramConnection::has_datagram() {
    if (unsent_) return true;
    if (!leaving_.empty()) {
        datagram_ = std::move(leaving_.front());
        leaving_.pop_front();
        return true;
    }
    if (queue_.empty()) return false;
    take_from_queue(datagram_);
    return true;
}

void DatagramConnection::take_from_queue(std::vector<std::byte>& datagram) {
    frame_.clear();
    queue_.take(frame_, 1);
    wrap(frame_, datagram);
}

void DatagramConnection::wrap(std::span<const std::byte> frame, std::vector<std::byte>& datagram) {
    codec_.wrap(frame, datagram, Clock::now());
    counts_.bytes_out += line_.bytes_of(datagram);
}

// Sends a sign of life when we have been silent for a while, and ends the link when the peer has been silent
// for too long.
void DatagramConnection::look_after() {
    const auto now = Clock::now();
    if (closing_) {
        if (now >= closed_at_ + longest_farewell) release();
    } else if (now > heard_ + silence_limit_) {
        return fail({Error::Kind::closed,
                     "nothing has come from the peer for " + std::to_string(silence_limit_.count()) + " ms"});
    } else if (now >= told_ + silence_limit_ / signs_of_life && !unsent_) {
        wrap({}, datagram_);
        unsent_ = true;
        write();
    }
    if (!port_) return;
    timer_.expires_after(silence_limit_ / (2 * signs_of_life));
    timer_.async_wait([self = shared_from_this()](const boost::system::error_code& error) {
        if (!error) self->look_after();
    });
}

void DatagramConnection::close() {
    callbacks_.reset();
    if (std::exchange(closing_, true)) return;
    closed_at_ = Clock::now();
    // All is counted as sent before the session asks for the counts.
    while (!queue_.empty()) take_from_queue(leaving_.emplace_back());
    if (leaving_.empty() && !unsent_)
        release();
    else
        look_after();
}

void DatagramConnection::abort() {
    callbacks_.reset();
    closing_ = true;
    release();
}

void DatagramConnection::release() {
    timer_.cancel();
    port_.reset();
    // May be the last that holds the connection itself.
    const auto owner = std::exchange(owner_, nullptr);
}

void DatagramConnection::fail(const Error& error) {
    const auto callbacks = callbacks_;
    abort();
    if (callbacks) callbacks->closed(error);
}

}  // namespace afferent
