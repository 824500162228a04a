#include "bench/contact_latency.hpp"

#include <array>
#include <iomanip>
#include <sstream>

#include "afferent/studies/trial/experiment.hpp"
#include "afferent/studies/trial/tally.hpp"

namespace afferent::bench {
namespace {

Scene with_chain(Scene scene, double rate_hz, std::optional<double> prompt_ms) {
    for (scene::Patch& patch : scene.patches) patch.sensor.rate_hz = rate_hz;
    scene.link.prompt_ms = prompt_ms;
    return scene;
}

struct Chain {
    const char* name;
    Scene scene;
};

std::vector<Chain> chains(const Scene& scene) {
    const Scene prompt = with_chain(scene, 1000, 1);
    if (scene.patches == prompt.patches && scene.link.prompt_ms == prompt.link.prompt_ms)
        return {{"the scene's", scene}, {"200 Hz, no prompt_ms", with_chain(scene, 200, std::nullopt)}};
    return {{"the scene's", scene}, {"1 kHz, prompt_ms 1", prompt}};
}

std::optional<double> in_milliseconds(std::optional<double> seconds) {
    return seconds ? std::optional(*seconds * 1e3) : std::nullopt;
}

std::string whole_ms(std::optional<double> ms) {
    std::ostringstream text;
    if (ms)
        text << std::fixed << std::setprecision(0) << *ms;
    else
        text << '-';
    return text.str();
}

}  // namespace

std::vector<ContactLatency> measure_contact_latency(const Scene& scene, std::uint32_t presentations,
                                                    const std::function<void(double)>& progress) {
    constexpr std::array names{"force", "rate", "exponential", "interval", "inversion", "filter"};
    std::vector<ContactLatency> rows;
    for (const auto& [chain, measured] : chains(scene)) {
        for (const char* const name : names) {
            const Experiment experiment(measured, name);
            const Tally delicate = tally(experiment.present(0, presentations)).delicate;
            rows.push_back({name, chain, Milliseconds(experiment.plan().latency.most()).count(),
                            in_milliseconds(delicate.told_s(0.5)), delicate.answers(),
                            in_milliseconds(delicate.answer_s(0.1)), in_milliseconds(delicate.answer_s(0.5)),
                            in_milliseconds(delicate.answer_s(0.9))});
            progress(static_cast<double>(rows.size()) / (2 * names.size()));
        }
    }
    return rows;
}

void print_contact_latency(const std::vector<ContactLatency>& rows, std::ostream& out) {
    out << "| decoder | chain | told, median, ms | answered | median, ms | 10 to 90 %, ms | plan's budget, "
           "ms |\n"
           "|---|---|---|---|---|---|---|\n";
    for (const ContactLatency& row : rows)
        out << "| `" << row.condition << "` | " << row.chain << " | " << whole_ms(row.told_median_ms) << " | "
            << row.answered << " | " << whole_ms(row.median_ms) << " | " << whole_ms(row.p10_ms) << " to "
            << whole_ms(row.p90_ms) << " | " << whole_ms(row.budget_ms) << " |\n";
}

}  // namespace afferent::bench
