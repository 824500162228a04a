#include "afferent/view/view.hpp"

#include <algorithm>
#include <atomic>
#include <map>
#include <utility>

#include "afferent/io/wire/raw_samples.hpp"
#include "afferent/view/messages.hpp"
#include "afferent/view/server.hpp"
#include "afferent/view/token.hpp"

namespace afferent {
namespace {

constexpr Duration kept = std::chrono::seconds(60);

// Elements that are sampled together go into one frame.
double raw_bytes_per_s(const Plan& plan) {
    std::map<double, std::size_t> samples_by_rate;
    unsigned bits = 0;
    for (const PatchPlan& patch : plan.patches) bits = std::max(bits, patch.sensor.adc_bits);
    for (const PatchPlan& patch : plan.patches)
        if (patch.owns_elements) samples_by_rate[patch.sensor.rate_hz] += patch.elements();
    double bytes = 0;
    for (const auto& [rate_hz, samples] : samples_by_rate)
        bytes += rate_hz * static_cast<double>(raw_sample_bytes(samples, bits));
    return bytes;
}

ViewTitle title_of(const Plan& plan, const View::Options& options) {
    ViewTitle title{.course = {},
                    .command = options.command,
                    .scene = plan.scene.name,
                    .limit_n = {},
                    .raw_bytes_per_s = raw_bytes_per_s(plan)};
    if (plan.controller) title.limit_n = plan.scene.gain.limit_n;
    return title;
}

}  // namespace

// The feed is filled by others; the rest is the server's thread's.
struct View::State {
    State(const Plan& plan, const Options& options)
        : layout(plan), feed(layout), title(title_of(plan, options)) {}

    ViewTitle title_now() const {
        ViewTitle now = title;
        now.course = program + "-" + std::to_string(feed.course());
        return now;
    }
    std::string greeting() const { return hello_message(title_now(), layout, last, told_end); }

    std::vector<ViewMessage> news(bool at_end) {
        std::vector<ViewMessage> messages;
        const std::uint32_t before = feed.course();
        const bool is_over = at_end || ended;
        for (Portion portion = feed.take(); !portion.empty(); portion = is_over ? feed.take() : Portion()) {
            if (feed.course() != before) last = Portion();
            last.append(portion);
            last.keep_last(kept, layout.bin());
            if (feed.course() != before)
                messages.push_back({greeting(), true});
            else
                messages.push_back({update_message(portion, feed.dropped())});
        }
        if (at_end || (is_over && !told_end)) {
            told_end = true;
            messages.push_back({end_message()});
        }
        return messages;
    }

    const RasterLayout layout;
    ViewFeed feed;
    const ViewTitle title;
    const std::string program = random_token().substr(0, 8);  // tells it from one that is started again
    Portion last;
    std::atomic<bool> ended{false};
    bool told_end = false;
};

View::View() = default;
View::~View() = default;

Result<std::unique_ptr<View>> View::open(const Plan& plan, const Options& options) {
    std::string token;
    if (options.token_file.empty()) {
        token = random_token();
    } else {
        AFFERENT_TRY(kept, kept_token(options.token_file));
        token = std::move(kept);
    }
    std::unique_ptr<View> view(new View);
    view->state_ = std::make_unique<State>(plan, options);
    AFFERENT_TRY(
        server,
        ViewServer::open(token, options.port, {},
                         {.greeting = [state = view->state_.get()] { return state->greeting(); },
                          .news = [state = view->state_.get()](bool last) { return state->news(last); }}));
    view->server_ = std::move(server);
    return view;
}

std::string View::url() const { return server_->url(); }
std::size_t View::viewers() const noexcept { return server_->counts().viewers; }
ViewFeed& View::feed() noexcept { return state_->feed; }
void View::end() noexcept { state_->ended = true; }

}  // namespace afferent
