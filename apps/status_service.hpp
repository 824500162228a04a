// Serves the state of a session to other processes on this machine; `afferent link status` reads it.
#pragma once

#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "afferent/apps/summary.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// Answers every connection to a Unix socket, which only this user can open, with one summary as JSON.
class StatusService {
  public:
    // If the socket cannot be opened, for example because another process serves this end of the scene,
    // there is no service and no error: a session does not depend on being watched.
    StatusService(boost::asio::io_context& io, const Scene& scene, const std::string& link_end,
                  std::function<Summary()> status);
    ~StatusService();

  private:
    struct State;
    std::shared_ptr<State> state_;
};

// Nothing if no process serves that end of the scene. If it does not answer within two seconds, perhaps
// because it is stopped, its session is "does not answer".
std::optional<Summary> ask_status(const Scene& scene, const std::string& link_end);

}  // namespace afferent
