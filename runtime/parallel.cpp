#include "afferent/runtime/parallel.hpp"

#if defined(__SANITIZE_THREAD__)
// Debian's TBB is not instrumented and gives false reports under ThreadSanitizer, so plain threads replace
// it.
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>
#else
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#endif

namespace afferent {

#if defined(__SANITIZE_THREAD__)

class Workers::Pool {
  public:
    explicit Pool(std::size_t threads) : threads_(threads) {}

    void run(std::size_t count, const std::function<void(std::size_t)>& piece) {
        std::atomic<std::size_t> next{0};
        std::exception_ptr failure;
        std::mutex failure_mutex;
        const auto work = [&] {
            try {
                for (std::size_t i = next++; i < count; i = next++) piece(i);
            } catch (...) {
                const std::lock_guard lock(failure_mutex);
                if (!failure) failure = std::current_exception();
            }
        };
        {
            std::vector<std::jthread> others;
            for (std::size_t k = 1; k < threads_; ++k) others.emplace_back(work);
            work();
        }
        if (failure) std::rethrow_exception(failure);
    }

  private:
    std::size_t threads_;
};

#else

class Workers::Pool {
  public:
    explicit Pool(std::size_t threads) : arena_(static_cast<int>(threads)) {}

    void run(std::size_t count, const std::function<void(std::size_t)>& piece) {
        arena_.execute([&] { tbb::parallel_for(std::size_t{0}, count, piece); });
    }

  private:
    tbb::task_arena arena_;
};

#endif

Workers::Workers(std::size_t threads) : threads_(threads) {
    if (threads_ > 1) pool_ = std::make_unique<Pool>(threads_);
}
Workers::~Workers() = default;
Workers::Workers(Workers&&) noexcept = default;
Workers& Workers::operator=(Workers&&) noexcept = default;

void Workers::run(std::size_t count, const std::function<void(std::size_t)>& piece) {
    if (pool_) {
        pool_->run(count, piece);
    } else {
        for (std::size_t i = 0; i < count; ++i) piece(i);
    }
}

}  // namespace afferent
