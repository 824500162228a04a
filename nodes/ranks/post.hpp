// Messages between two ranks, sent and received without waiting.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace afferent::ranks {

enum class Kind : int {
    samples,  // rank 0's, of a window
    events,   // of a window
    failure,  // in words: there will be no more events
    stop,     // from rank 0: whatever you are doing, end
    report,   // the last message of a rank
};

using Bytes = std::vector<std::byte>;

// Receives the next message from that rank, if there is one; `bytes` is reused.
std::optional<Kind> receive(std::size_t from, Bytes& bytes);

// What one rank has sent to another and it has not begun to receive. Messages arrive in their order.
class Outbox {
  public:
    explicit Outbox(std::size_t to);
    ~Outbox();
    Outbox(Outbox&&) noexcept;
    Outbox& operator=(Outbox&&) noexcept;

    // Several ranks may be sent the same bytes, which must not change until they have them.
    void send(Kind kind, std::shared_ptr<const Bytes> bytes);
    // How many messages the other has not begun to receive.
    std::size_t waiting();

  private:
    struct Sending;
    std::size_t to_;
    std::vector<Sending> sending_;  // the oldest first
};

// Buffers of messages; one that has been received is used again.
class Buffers {
  public:
    // An empty one.
    std::shared_ptr<Bytes> next();

  private:
    std::vector<std::shared_ptr<Bytes>> all_;
};

}  // namespace afferent::ranks
