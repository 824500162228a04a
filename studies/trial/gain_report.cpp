#include "afferent/studies/trial/gain_report.hpp"

#include <algorithm>
#include <iomanip>
#include <utility>

#include "afferent/io/files/table_writer.hpp"
#include "afferent/io/pictures/panel_grid.hpp"
#include "afferent/studies/trial/percent.hpp"

namespace afferent {
namespace {

// Hands that drop more are of no use to anybody; the table has them.
constexpr double drawn_dropped_pct = 12;

const GainTrial& chosen(const GainFront& front) { return front.gains[front.chosen]; }

// The chosen gains of two conditions in the same presentations: what breaks under the second less what breaks
// under the first.
struct Compared {
    std::string first, second;
    Estimated broken;
};

std::vector<Compared> compared_with_first(const std::vector<GainFront>& fronts) {
    std::vector<Compared> compared;
    for (std::size_t i = 1; i < fronts.size(); ++i)
        if (const auto broken = broken_difference(chosen(fronts[0]).held_out, chosen(fronts[i]).held_out))
            compared.push_back({fronts[0].condition, fronts[i].condition, *broken});
    return compared;
}

void add_outcome(Summary& summary, const std::string& name, const Tallies& tallies) {
    add_percent(summary, name + "_broken", tallies.delicate.broken());
    add_percent(summary, name + "_delicate_dropped", tallies.delicate.dropped());
    add_percent(summary, name + "_heavy_dropped", tallies.slippery.dropped());
}

Summary summary_of(const GainTrial& one, bool is_chosen) {
    Summary summary{{"onset_n", one.gain.onset_n},
                    {"lambda_n", one.gain.lambda_n},
                    {"upper_bound_sigmas", one.gain.upper_bound_sigmas},
                    {"lead_ms", one.gain.lead_ms},
                    {"chosen", is_chosen}};
    add_outcome(summary, "searched", one.searched);
    add_outcome(summary, "held_out", tally(one.held_out));
    return summary;
}

}  // namespace

Summary summary_of(const std::vector<GainFront>& fronts) {
    Summary summary;
    for (const GainFront& front : fronts) {
        Summary entry{{"condition", front.condition}, {"is_allowed", front.is_allowed}};
        for (const GainTrial& one : front.gains)
            entry["gains"].push_back(summary_of(one, &one == &chosen(front)));
        summary["fronts"].push_back(std::move(entry));
    }
    for (const auto& [first, second, broken] : compared_with_first(fronts)) {
        Summary entry{{"condition", second}, {"against", first}};
        entry["broken"] = summary_of(broken, 100, "_points");
        summary["compared"].push_back(std::move(entry));
    }
    return summary;
}

void print_gains(const std::vector<GainFront>& fronts, std::ostream& out) {
    out << "What is not beaten in both, delicate objects that break and heavy ones that drop, in %; * is "
           "chosen.\nSearched on some objects, and counted again on others, which are held out:\n\n"
        << std::left << std::setw(14) << "condition" << std::right << std::setw(9) << "onset N"
        << std::setw(10) << "lambda N" << std::setw(8) << "sigmas" << std::setw(9) << "lead ms"
        << std::setw(10) << "searched" << std::setw(9) << "dropped" << std::setw(10) << "held out"
        << std::setw(14) << "95 %" << std::setw(9) << "dropped" << std::setw(14) << "95 %" << '\n';
    for (const GainFront& front : fronts)
        for (const GainTrial& one : front.gains) {
            const auto [delicate, slippery] = tally(one.held_out);
            const Proportion broken = delicate.broken();
            const Proportion dropped = slippery.dropped();
            out << std::left << std::setw(14) << (&one == &front.gains.front() ? front.condition : "")
                << std::right << std::setw(9) << fixed(one.gain.onset_n, 2) << std::setw(10)
                << fixed(one.gain.lambda_n, 2) << std::setw(8) << fixed(one.gain.upper_bound_sigmas, 1)
                << std::setw(9) << fixed(one.gain.lead_ms, 0) << std::setw(10)
                << fixed(percent(one.searched.delicate.broken()), 2) << std::setw(9)
                << fixed(percent(one.searched.slippery.dropped()), 2) << std::setw(10)
                << fixed(percent(broken), 2) << std::setw(14) << range_of(broken) << std::setw(9)
                << fixed(percent(dropped), 2) << std::setw(14) << range_of(dropped)
                << (&one == &chosen(front) ? " *" : "") << '\n';
        }
    for (const GainFront& front : fronts)
        if (!front.is_allowed)
            out << "\nWith every gain of " << front.condition
                << " that was left, more heavy objects drop than allowed: * is that with which the fewest "
                   "do.\n";
    const auto compared = compared_with_first(fronts);
    if (compared.empty()) return;
    out << "\nBroken with the chosen gains, against " << compared.front().first
        << ", in the same held-out presentations:\ndifference in points, with its 95 % interval\n\n";
    for (const auto& [first, second, broken] : compared)
        out << std::left << std::setw(16) << second << points(broken) << '\n';
}

Result<void> write_gains(const std::vector<GainFront>& fronts, const std::filesystem::path& file) {
    TableWriter table(
        file, {"condition", "onset_n", "lambda_n", "upper_bound_sigmas", "lead_ms", "searched_broken_pct",
               "searched_broken_low_pct", "searched_broken_high_pct", "searched_heavy_dropped_pct",
               "searched_heavy_dropped_low_pct", "searched_heavy_dropped_high_pct", "held_out_broken_pct",
               "held_out_broken_low_pct", "held_out_broken_high_pct", "held_out_heavy_dropped_pct",
               "held_out_heavy_dropped_low_pct", "held_out_heavy_dropped_high_pct", "chosen"});
    for (const GainFront& front : fronts)
        for (const GainTrial& one : front.gains) {
            table.text(front.condition);
            for (const double value :
                 {one.gain.onset_n, one.gain.lambda_n, one.gain.upper_bound_sigmas, one.gain.lead_ms})
                table.cell(value);
            const Tallies held_out = tally(one.held_out);
            for (const Tallies* tallies : {&one.searched, &held_out})
                for (const Proportion& counted : {tallies->delicate.broken(), tallies->slippery.dropped()}) {
                    const Bounds interval = interval_95(counted);
                    for (const double share : {counted.value(), interval.low, interval.high})
                        table.cell(100 * share, 3);
                }
            table.cell(std::uint64_t{&one == &chosen(front)});
            table.end_row();
        }
    if (const auto error = table.close()) return Error{Error::Kind::unreachable, error->message()};
    return success();
}

Drawing draw_gains(const std::vector<GainFront>& fronts, double most_dropped,
                   const std::filesystem::path& stem) {
    PanelGrid::Panel panel{.title = "",
                           .x_title = "heavy objects dropped (%)",
                           .y_title = "delicate objects broken (%)",
                           .curves = {},
                           .levels = {{"allowed", 100 * most_dropped, true}},
                           .y_range = {},
                           .x_range = std::pair(0.0, std::max(drawn_dropped_pct, 400 * most_dropped))};
    for (const GainFront& front : fronts) {
        PanelGrid::Curve curve{.name = front.condition, .x = {}, .y = {}, .marked = true};
        for (const GainTrial& one : front.gains) {
            const auto [delicate, slippery] = tally(one.held_out);
            const Proportion broken = delicate.broken();
            curve.x.push_back(percent(slippery.dropped()));
            curve.y.push_back(percent(broken));
            curve.low.push_back(100 * interval_95(broken).low);
            curve.high.push_back(100 * interval_95(broken).high);
        }
        panel.curves.push_back(std::move(curve));
    }
    PanelGrid picture{
        .title = "What each condition can have with the gain that suits it, on objects held out",
        .columns = 1,
        .panels = {std::move(panel)},
        .panel_height = 420};
    return draw(picture, stem);
}

Scene with_chosen_gains(Scene scene, const std::vector<GainFront>& fronts) {
    for (const GainFront& front : fronts) {
        auto& stated = scene.trial->conditions;
        std::erase_if(stated, [&](const scene::TrialCondition& one) { return one.name == front.condition; });
        stated.push_back({front.condition, chosen(front).gain});
    }
    return scene;
}

}  // namespace afferent
