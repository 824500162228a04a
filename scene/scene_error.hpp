// The exception for an invalid scene. Included by programs that catch it.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace afferent {

// Its text lists all errors of a scene, one per line. Each begins with its place in the file, or with the
// path of the field if there is no file:
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
