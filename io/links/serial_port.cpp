#include "afferent/io/links/serial_port.hpp"

#include <sys/file.h>

#include <algorithm>
#include <array>
#include <boost/asio/error.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/serial_port.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <utility>
#include <vector>

#include "afferent/io/links/serial_device.hpp"
#include "afferent/io/wire/cobs.hpp"
#include "afferent/io/wire/frame.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;

// A start bit, eight of data, a stop bit.
constexpr int bits_per_byte = 10;

class SerialPort final : public DatagramPort, public std::enable_shared_from_this<SerialPort> {
  public:
    SerialPort(asio::serial_port port, std::uint32_t baud)
        : port_(std::move(port)), free_(port_.get_executor()), baud_(baud), reader_(longest_datagram_bytes) {}

    void start(std::weak_ptr<DatagramPortUser> user) override {
        user_ = std::move(user);
        read();
    }

    std::size_t send(const DatagramPeer&, std::span<const std::byte> datagram) override {
        if (busy_) {
            waited_for_ = true;
            return 0;
        }
        busy_ = true;
        append_cobs(datagram, out_);
        free_at_ = std::max(free_at_, Clock::now() - longest_catch_up) +
                   std::chrono::nanoseconds(std::int64_t{1'000'000'000} * bits_per_byte *
                                            static_cast<std::int64_t>(out_.size()) / baud_);
        asio::async_write(
            port_, asio::buffer(out_.data(), out_.size()),
            [self = shared_from_this()](const error_code& error, std::size_t) { self->has_written(error); });
        return out_.size();
    }

    DatagramLine line() const override {
        return {.handshake_bytes = 300,
                .byte_time = std::chrono::nanoseconds(std::int64_t{1'000'000'000} * bits_per_byte / baud_),
                .bytes_of = [](std::span<const std::byte> datagram) {
                    std::vector<std::byte> stuffed;
                    append_cobs(datagram, stuffed);
                    return stuffed.size();
                }};
    }

    void close() override {
        user_.reset();
        if (!busy_) return shut();
        // There is a limit, because a line may never take another byte.
        free_.expires_after(longest_farewell);
        free_.async_wait([self = shared_from_this()](const error_code&) { self->shut(); });
    }

  private:
    static constexpr std::chrono::milliseconds longest_farewell{500};
    // After a delay of the loop, this much of what the line could have sent meanwhile is given to it at once.
    static constexpr std::chrono::milliseconds longest_catch_up{10};

    void read() {
        port_.async_read_some(asio::buffer(in_),
                              [self = shared_from_this()](const error_code& error, std::size_t count) {
                                  self->has_read(error, count);
                              });
    }

    void has_read(const error_code& error, std::size_t count) {
        if (error) return fail(error);
        const std::uint64_t garbage = reader_.refused();
        reader_.read(std::span(in_).first(count), [this](std::span<const std::byte> datagram) {
            if (const auto user = user_.lock()) user->received({}, datagram);
        });
        const auto user = user_.lock();
        if (user && reader_.refused() > garbage) user->received_garbage(reader_.refused() - garbage);
        if (port_.is_open()) read();
    }

    void has_written(const error_code& error) {
        if (error) return fail(error);
        if (user_.expired()) return shut();
        out_.clear();
        free_.expires_at(free_at_);
        free_.async_wait([self = shared_from_this()](const error_code&) {
            self->busy_ = false;
            const auto user = self->user_.lock();
            if (user && std::exchange(self->waited_for_, false)) user->writable();
        });
    }

    void fail(const error_code& error) {
        const auto user = user_.lock();
        user_.reset();
        shut();
        if (user) user->failed({Error::Kind::closed, "the serial line has failed: " + error.message()});
    }

    void shut() {
        error_code ignored;
        free_.cancel();
        port_.close(ignored);
    }

    asio::serial_port port_;
    asio::steady_timer free_;  // when the line is, of what has been written
    Clock::time_point free_at_;
    std::uint32_t baud_;
    CobsReader reader_;
    std::weak_ptr<DatagramPortUser> user_;
    bool busy_ = false;
    bool waited_for_ = false;
    std::vector<std::byte> out_;
    std::array<std::byte, 4096> in_;
};

}  // namespace

Result<asio::serial_port> open_serial_device(asio::io_context& io, const std::string& device,
                                             std::uint32_t baud) {
    const auto unreachable = [](const std::string& text) { return Error{Error::Kind::unreachable, text}; };
    if (baud == 0) return unreachable("the baud rate must be > 0");
    asio::serial_port port(io);
    error_code error;
    port.open(device, error);
    if (error) return unreachable(error.message());
    if (::flock(port.native_handle(), LOCK_EX | LOCK_NB) != 0)
        return unreachable("another program has opened it");
    using Option = asio::serial_port_base;
    port.set_option(Option::baud_rate(baud), error);
    if (error) return unreachable("the device does not support " + std::to_string(baud) + " baud");
    // Asio has set raw mode. Most devices start with these settings, and some refuse to have them set.
    error_code ignored;
    port.set_option(Option::character_size(8), ignored);
    port.set_option(Option::parity(Option::parity::none), ignored);
    port.set_option(Option::stop_bits(Option::stop_bits::one), ignored);
    port.set_option(Option::flow_control(Option::flow_control::none), ignored);
    return port;
}

Result<std::shared_ptr<DatagramPort>> open_serial_port(asio::io_context& io, const std::string& device,
                                                       std::uint32_t baud) {
    AFFERENT_TRY(port, open_serial_device(io, device, baud));
    return std::shared_ptr<DatagramPort>(std::make_shared<SerialPort>(std::move(port), baud));
}

}  // namespace afferent
