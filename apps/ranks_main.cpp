// The program afferent-ranks: what `mpirun -n K afferent run` becomes, once in each process.
#include <fcntl.h>
#include <unistd.h>

#include <cmath>
#include <memory>
#include <optional>

#include "afferent/apps/cli.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/run_scene.hpp"
#include "afferent/nodes/ranks/event_gather.hpp"
#include "afferent/nodes/ranks/share.hpp"
#include "afferent/nodes/ranks/worker.hpp"

namespace afferent {
namespace {

using ranks::World;

// Rank 0 speaks for all.
void be_silent() {
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
    ::close(nowhere);
}

// A list with an entry for each rank.
template <class Value>
Summary by_rank(std::size_t ranks, Value&& value) {
    Summary::List list;
    for (std::size_t rank = 0; rank < ranks; ++rank) list.push_back(value(rank));
    return list;
}

// What rank 0 does not sample is counted by those that do. What all samples together would take on a
// link, nobody knows then.
void add_samples(Summary& summary, const ranks::Share& share, const std::vector<ranks::Report>& reports) {
    std::uint64_t samples = 0;
    std::uint64_t clipped = 0;
    for (const ranks::Report& report : reports) {
        samples += report.samples;
        clipped += report.clipped;
    }
    const auto add = [&](const char* key, std::uint64_t more) {
        if (const auto* count = std::get_if<std::uint64_t>(&summary[key].value()))
            summary[key] = *count + more;
    };
    add("samples", samples);
    add("clipped_samples", clipped);
    if (!share.first_samples_all) summary["raw_sample_bytes"] = Summary();
}

void add_ranks(Summary& summary, const ranks::Share& share, const std::vector<ranks::Report>& reports) {
    const std::size_t count = reports.size();
    const auto windows = static_cast<double>(std::max<std::uint64_t>(1, reports.front().windows));
    const auto ms_per_window = [&](double ranks::Report::*seconds) {
        return by_rank(count, [&, seconds](std::size_t r) {
            // Microseconds tell more than a clock that other processes disturb.
            return Summary(std::round(reports[r].*seconds / windows * 1e6) / 1e3);
        });
    };
    std::uint64_t bytes = 0;
    for (const ranks::Report& report : reports) bytes += report.bytes;
    summary["ranks"] = count;
    summary["windows"] = reports.front().windows;
    summary["load_measured_over_s"] = share.measured_s;
    summary["rank_afferents"] = by_rank(count, [&](std::size_t r) { return Summary(share.afferents[r]); });
    summary["rank_events"] = by_rank(count, [&](std::size_t r) { return Summary(reports[r].events); });
    summary["compute_ms_per_window"] = ms_per_window(&ranks::Report::compute_s);
    summary["rest_ms_per_window"] = ms_per_window(&ranks::Report::rest_s);
    summary["wait_ms_per_window"] = ms_per_window(&ranks::Report::wait_s);
    summary["run_ms_per_window"] = ms_per_window(&ranks::Report::run_s);
    summary["gathered_bytes_per_window"] = static_cast<double>(bytes) / windows;
}

struct Options {
    RunOptions run;
    double rank_timeout_s = 60;
};

// Rank 0: everything but the neurons of the others.
void run_first(World& world, const Options& options, const Plan& plan, const ranks::Share& share) {
    std::vector<bool> computes;
    for (const std::uint64_t afferents : share.afferents) computes.push_back(afferents > 0);
    ranks::Patience patience;
    patience.longest = std::chrono::duration_cast<ranks::Clock::duration>(Seconds(options.rank_timeout_s));
    patience.interrupted = interrupted;
    ranks::EventGather gather(world, computes, share.samples_are_sent, patience);
    run_scene(options.run, plan, &gather, [&](Summary& summary) {
        gather.end();
        add_samples(summary, share, gather.reports());
        add_ranks(summary, share, gather.reports());
    });
    if (gather.error()) throw Failure(gather.error()->text);
}

void run_rank(World& world, const Options& options) {
    catch_interrupts();
    std::optional<Plan> plan;
    std::string failure;
    bool draws = false;
    try {
        Scene scene = options.run.scene.read();
        // A picture shows where the skin is touched.
        draws = scene.record.picture && !options.run.out.empty();
        // Only rank 0 decodes, and only it needs to plan that.
        if (!world.is_first()) scene.record = {.events = false, .force = false, .picture = false};
        if (!world.is_first()) scene.output.clear();
        plan = make_plan(scene);
    } catch (const std::exception& error) {
        failure = error.what();
    }
    if (const auto why = ranks::disagreement(world, plan ? &*plan : nullptr, failure)) throw Failure(*why);
    const ranks::Share share = ranks::share_out(world, *plan, draws);
    if (world.is_first())
        run_first(world, options, *plan, share);
    else
        ranks::work(world, *plan, share);
}

Command ranked_run_command(World& world) {
    const auto options = std::make_shared<Options>();
    return {
        .name = "run",
        .help = "Run a scene in several processes, in virtual time, or paced by the wall clock",
        .footer = "Example:\n  mpirun -n 4 afferent run examples/fingertip.txtpb --json",
        .options = options->run.followed_by({
            option("--rank-timeout", options->rank_timeout_s,
                   "Seconds after which a rank that sends no events ends the run")
                .positive()
                .show_default(),
        }),
        .run = [options, &world] { run_rank(world, *options); },
    };
}

}  // namespace
}  // namespace afferent

int main(int argc, char** argv) {
    using namespace afferent;
    ranks::World world(argc, argv);
    if (!world.is_first()) be_silent();
    const int code = run_program(
        {
            .name = "afferent",
            .help = "A run in several processes, started by mpirun. All else is done by afferent itself.",
            .footer =
                std::string("Example:\n  mpirun -n 4 afferent run examples/fingertip.txtpb\n\n") + exit_codes,
            .commands = {ranked_run_command(world)},
        },
        AFFERENT_VERSION, argc, argv);
    // mpirun reports the code of rank 0, which has said why.
    return world.is_first() ? code : EXIT_SUCCESS;
}
