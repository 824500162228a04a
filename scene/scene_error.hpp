// The exception of scenes.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace afferent {

// Everything that is wrong at once, one message a line. Where the scene came from a file each begins with its
// place there, otherwise with the path of the field:
//
//     scene.txtpb:14:7: patch "thumb": neuron.tau_m_ms must be > 0, is -10
class SceneError : public std::runtime_error {
  public:
    explicit SceneError(std::vector<std::string> messages);
    const std::vector<std::string>& messages() const noexcept { return messages_; }

  private:
    std::vector<std::string> messages_;
};

}  // namespace afferent
