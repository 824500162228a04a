// Shows a running scene in browsers on this machine.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "afferent/runtime/result.hpp"
#include "afferent/scene/plan.hpp"
#include "afferent/view/feed.hpp"

namespace afferent {

class ViewServer;

// What runs the scene fills the feed and waits for nothing; a thread of the view's own takes it, keeps the
// last minute for viewers that come later, and serves the page (docs/view.md).
//
//     auto view = View::open(plan, {.command = "hand"});
//     ... view.value()->url() ...
//     observer.step = [&](const ControllerStep& step) { view.value()->feed().step(step); };
class View {
  public:
    struct Options {
        std::string command;     // for the page's title
        std::uint16_t port = 0;  // 0: any free one
        // Where the token of the address is kept, so that a program that is started again has the same
        // address. Empty: it is not kept.
        std::filesystem::path token_file = {};
    };
    // The plan is not needed any more afterwards.
    static Result<std::unique_ptr<View>> open(const Plan& plan, const Options& options);
    // Shows what is in the feed to its end. Takes at most half a second, whatever the viewers do.
    ~View();

    // The page's address. Everyone on this machine who knows it can see the view.
    std::string url() const;
    std::size_t viewers() const noexcept;
    ViewFeed& feed() noexcept;
    // Says that the scene has ended, once what is in the feed has been shown. The view stays.
    void end() noexcept;

  private:
    struct State;
    View();

    std::unique_ptr<State> state_;
    std::unique_ptr<ViewServer> server_;
};

}  // namespace afferent
