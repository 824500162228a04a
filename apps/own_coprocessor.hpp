// The coprocessor of a hand in the hand's process: where the sensors are on the hand's own line, or both ends
// of a chip's scene are shown.
#pragma once

#include <atomic>
#include <thread>

#include "afferent/scene/scene.hpp"

namespace afferent {

// A CoprocessorNode on a thread of its own, which reaches the hand over the scene's link like any other. One
// that fails begins again. The scene outlives this.
class OwnCoprocessor {
  public:
    explicit OwnCoprocessor(const Scene& scene);
    // Ends the session.
    ~OwnCoprocessor();
    OwnCoprocessor(const OwnCoprocessor&) = delete;
    OwnCoprocessor& operator=(const OwnCoprocessor&) = delete;

  private:
    void run(const Scene& scene);

    std::atomic<bool> ends_{false};
    std::thread thread_;
};

}  // namespace afferent
