#include "afferent/io/files/row_pipe.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace afferent {

RowPipe::RowPipe(std::filesystem::path pipe, std::string head)
    : pipe_(std::move(pipe)), head_(std::move(head)) {
    open();
}

RowPipe::~RowPipe() { close(); }

// Opening fails if there is no reader; without O_NONBLOCK it would wait for one.
void RowPipe::open() {
    file_ = ::open(pipe_.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    error_ = file_ < 0 && errno != ENXIO ? errno : 0;
    if (file_ < 0) return;
    waiting_ = head_;
    head_bytes_ = head_.size();
}

void RowPipe::put(std::string_view row) {
    if (file_ < 0) open();
    if (file_ < 0 || waiting_.size() - written_ + row.size() > most_waiting) {
        ++lost_rows_;
    } else {
        waiting_ += row;
    }
    while (file_ >= 0 && written_ < waiting_.size() && write_some()) {
    }
}

bool RowPipe::write_some() {
    const ssize_t count = ::write(file_, waiting_.data() + written_, waiting_.size() - written_);
    if (count < 0 && errno == EINTR) return true;
    if (count < 0 && errno != EAGAIN) {
        // The reader has gone.
        close();
        return false;
    }
    if (count < 0) return false;
    written_ += static_cast<std::size_t>(count);
    // Written bytes are removed now and then, not with every row.
    if (written_ == waiting_.size() || written_ > most_waiting) {
        waiting_.erase(0, written_);
        written_ = head_bytes_ = 0;
    }
    return true;
}

bool RowPipe::finish(std::chrono::milliseconds patience) {
    while (file_ >= 0 && written_ < waiting_.size()) {
        pollfd ready{file_, POLLOUT, 0};
        const int count = ::poll(&ready, 1, static_cast<int>(patience.count()));
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) {
            close();
            return false;
        }
        write_some();
    }
    close();
    return true;
}

void RowPipe::close() {
    const std::string_view left = std::string_view(waiting_).substr(std::max(written_, head_bytes_));
    lost_rows_ += static_cast<std::uint64_t>(std::count(left.begin(), left.end(), '\n'));
    waiting_.clear();
    written_ = head_bytes_ = 0;
    if (file_ >= 0) ::close(std::exchange(file_, -1));
}

}  // namespace afferent
