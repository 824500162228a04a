// The only place that knows how work is distributed over threads.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace afferent {

// Runs independent pieces of work. With one thread it is a plain loop and starts nothing.
class Workers {
  public:
    explicit Workers(std::size_t threads);
    ~Workers();
    Workers(Workers&&) noexcept;
    Workers& operator=(Workers&&) noexcept;

    std::size_t threads() const noexcept { return threads_; }

    // Calls piece(0) ... piece(count - 1), in any order, and returns when all have returned. Rethrows the
    // first exception.
    void run(std::size_t count, const std::function<void(std::size_t)>& piece);

  private:
    class Pool;
    std::size_t threads_;
    std::unique_ptr<Pool> pool_;
};

}  // namespace afferent
