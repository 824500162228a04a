// How a session stands, for whoever asks on this machine: what `afferent link status` reads.
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

// Answers each who connects to a Unix socket of the user's own with one summary as JSON.
class StatusService {
  public:
    // Where the socket cannot be opened, for one because another process serves this side of the scene, there
    // is no service: a session does not depend on being watched.
    StatusService(boost::asio::io_context& io, const Scene& scene, const std::string& side,
                  std::function<Summary()> status);
    ~StatusService();

  private:
    struct State;
    std::shared_ptr<State> state_;
};

// Nothing where no process of ours serves that side of the scene. Of one that does not answer within two
// seconds, because it is stopped perhaps, no more than that.
std::optional<Summary> ask_status(const Scene& scene, const std::string& side);

}  // namespace afferent
