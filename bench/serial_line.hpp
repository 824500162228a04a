// A serial line without the hardware: two pseudo-terminals, and what carries the bytes between them.
#pragma once

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/write.hpp>
#include <cerrno>
#include <functional>
#include <string>
#include <system_error>

namespace afferent {

// The bytes written to one device are read from the other. Runs on the loop it is given.
class SerialLine {
  public:
    explicit SerialLine(boost::asio::io_context& io) : ends_{End(io), End(io)} {
        forward(ends_[0], ends_[1]);
        forward(ends_[1], ends_[0]);
    }
    SerialLine(const SerialLine&) = delete;
    SerialLine& operator=(const SerialLine&) = delete;

    const std::string& first() const noexcept { return ends_[0].device; }
    const std::string& second() const noexcept { return ends_[1].device; }

    // As if from the other side, whoever has the first or second device open.
    void disturb_first(const std::string& bytes) { put(ends_[0], bytes); }
    void disturb_second(const std::string& bytes) { put(ends_[1], bytes); }

    // Sees what passes from the second device to the first, and may change it.
    std::function<void(std::string&)> on_way_to_first;

  private:
    struct End {
        explicit End(boost::asio::io_context& io) : master(io) {
            const int descriptor = ::posix_openpt(O_RDWR | O_NOCTTY);
            check(descriptor >= 0);
            master.assign(descriptor);
            check(::grantpt(descriptor) == 0 && ::unlockpt(descriptor) == 0);
            std::array<char, 64> name{};
            check(::ptsname_r(descriptor, name.data(), name.size()) == 0);
            device = name.data();
            // Open all the while, so that the line outlives those at its ends; raw from the start.
            held = ::open(device.c_str(), O_RDWR | O_NOCTTY);
            termios settings{};
            check(held >= 0 && ::tcgetattr(held, &settings) == 0);
            ::cfmakeraw(&settings);
            check(::tcsetattr(held, TCSANOW, &settings) == 0);
            master.non_blocking(true);
        }
        ~End() { ::close(held); }
        End(const End&) = delete;
        End& operator=(const End&) = delete;

        static void check(bool done) {
            if (!done) throw std::system_error(errno, std::generic_category(), "a pseudo-terminal");
        }

        boost::asio::posix::stream_descriptor master;
        std::string device;
        int held = -1;
        std::array<char, 4096> bytes{};
    };

    void forward(End& from, End& to) {
        from.master.async_read_some(
            boost::asio::buffer(from.bytes),
            [this, &from, &to](const boost::system::error_code& error, std::size_t count) {
                if (error) return;
                std::string bytes(from.bytes.data(), count);
                if (&to == &ends_[0] && on_way_to_first) on_way_to_first(bytes);
                put(to, bytes);
                forward(from, to);
            });
    }

    static void put(End& to, const std::string& bytes) {
        // A device that nobody reads takes only so much, as a line without flow control.
        boost::system::error_code ignored;
        boost::asio::write(to.master, boost::asio::buffer(bytes), ignored);
    }

    std::array<End, 2> ends_;
};

}  // namespace afferent
