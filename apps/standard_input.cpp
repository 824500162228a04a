#include "afferent/apps/standard_input.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>

namespace afferent {
namespace {

bool standard_input_is_file() {
    struct stat status {};
    return ::fstat(STDIN_FILENO, &status) == 0 && S_ISREG(status.st_mode);
}

class Feeder : public std::enable_shared_from_this<Feeder> {
  public:
    Feeder(boost::asio::io_context& io, TableSource& table, std::function<void(const Error&)> on_error)
        : stream_(io, ::dup(STDIN_FILENO)), table_(table), on_error_(std::move(on_error)) {}

    void read() {
        stream_.async_read_some(
            boost::asio::buffer(buffer_),
            [weak = weak_from_this()](const boost::system::error_code& error, std::size_t count) {
                if (const auto self = weak.lock()) self->has_read(error, count);
            });
    }

  private:
    void has_read(const boost::system::error_code& error, std::size_t count) {
        if (error == boost::asio::error::operation_aborted) return;
        const Result<void> fed = error ? table_.finish() : table_.feed({buffer_.data(), count});
        if (!fed) return on_error_(fed.error());
        if (!error) read();
    }

    boost::asio::posix::stream_descriptor stream_;
    TableSource& table_;
    std::function<void(const Error&)> on_error_;
    std::array<char, 1 << 14> buffer_{};
};

}  // namespace

std::size_t read_standard_input(std::span<char> buffer) {
    const ssize_t count = ::read(STDIN_FILENO, buffer.data(), buffer.size());
    return count > 0 ? static_cast<std::size_t>(count) : 0;
}

TableSource::Read blocking_standard_input() {
    return standard_input_is_file() ? TableSource::Read(read_standard_input) : TableSource::Read();
}

std::shared_ptr<void> feed_standard_input(boost::asio::io_context& io, CoprocessorEnd& link_end,
                                          std::function<void(const Error&)> on_error) {
    if (!link_end.table() || !link_end.table()->is_fed()) return nullptr;
    const auto feeder = std::make_shared<Feeder>(io, *link_end.table(), std::move(on_error));
    feeder->read();
    return feeder;
}

}  // namespace afferent
