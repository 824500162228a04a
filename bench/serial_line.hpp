// A serial line without the hardware: two pseudo-terminals, and what carries the bytes between them.
#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/write.hpp>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>

#include "afferent/io/links/pseudo_terminal.hpp"

namespace afferent {

// The bytes written to one device are read from the other. Runs on the loop it is given.
class SerialLine {
  public:
    explicit SerialLine(boost::asio::io_context& io) : ends_{make_end(io), make_end(io)} {
        forward(ends_[0], ends_[1]);
        forward(ends_[1], ends_[0]);
    }
    SerialLine(const SerialLine&) = delete;
    SerialLine& operator=(const SerialLine&) = delete;

    const std::string& first() const noexcept { return ends_[0].terminal.device; }
    const std::string& second() const noexcept { return ends_[1].terminal.device; }

    // Writes to whoever has the first or second device open, as if from the other end.
    void disturb_first(const std::string& bytes) { put(ends_[0], bytes); }
    void disturb_second(const std::string& bytes) { put(ends_[1], bytes); }

    // Called with what passes from the second device to the first; may change it.
    std::function<void(std::string&)> on_way_to_first;

  private:
    struct End {
        PseudoTerminal terminal;
        std::array<char, 4096> bytes{};
    };

    static End make_end(boost::asio::io_context& io) {
        auto terminal = PseudoTerminal::open(io);
        if (!terminal) throw std::runtime_error(terminal.error().text);
        terminal.value().ours.non_blocking(true);
        return {std::move(terminal).value()};
    }

    void forward(End& from, End& to) {
        from.terminal.ours.async_read_some(
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
        // A device that nobody reads fills up and then loses bytes, like a line without flow control.
        boost::system::error_code ignored;
        boost::asio::write(to.terminal.ours, boost::asio::buffer(bytes), ignored);
    }

    std::array<End, 2> ends_;
};

}  // namespace afferent
