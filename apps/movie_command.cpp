// afferent movie: a population in motion, as a page for a browser.
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/standard_input.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/studies/movie.hpp"

namespace afferent {
namespace {

struct MovieCommandOptions {
    std::string from;
    std::string out;
    MovieOptions movie;
    std::vector<std::string> settings;
    bool json = false;
};

// Another movie of that name stays until this one is complete.
void write_page(const std::string& page, const std::string& file) {
    const std::filesystem::path unfinished = file + ".part";
    std::ofstream out(unfinished, std::ios::binary);
    out << page;
    out.close();
    std::error_code failure;
    if (out) std::filesystem::rename(unfinished, file, failure);
    if (!out || failure) throw Failure(file + ": cannot be written");
}

void make_movie(const MovieCommandOptions& options) {
    catch_interrupts();
    MovieOptions movie = options.movie;
    movie.settings = settings_of(options.settings);
    movie.standard_input = read_standard_input;
    Progress progress(options.from);
    movie.progress = [&](double share) {
        progress.at(share);
        return !interrupted();
    };
    const MovieOfPopulation made = value_or_fail(movie_of(options.from, movie));
    if (made.is_stopped) throw Interrupted();
    for (const std::string& remark : made.remarks) std::cerr << remark << '\n';
    write_page(made.page, options.out);
    print({{"movie", options.out},
           {"bytes", made.page.size()},
           {"afferents", made.afferents},
           {"events", made.events},
           {"from_s", seconds(made.begin)},
           {"to_s", seconds(made.end)},
           {"pressure", made.has_pressure}},
          options.json);
    if (!options.json) std::cout << "\nopen " << options.out << " in a browser\n";
}

}  // namespace

Command movie_command() {
    const auto options = std::make_shared<MovieCommandOptions>();
    return {
        .name = "movie",
        .help = "Show a population in motion: a page for a browser, with the skin from above and its spikes",
        .footer =
            "Examples:\n  afferent movie examples/fingertip.txtpb --out fingertip.html\n"
            "  afferent movie out/fingertip --out slow.html --from-s 0.5 --to-s 0.7\n\n"
            "The page needs no network and no other file. It plays at a speed that it states, from real time "
            "to "
            "1000 times slower; fingertip.html#t=0.5 opens it at that time.",
        .options =
            {
                positional(
                    "FROM", options->from,
                    "A scene, which is run; or a recording, a folder of results, or a file of events that "
                    "tells where its afferents are")
                    .required(),
                option("--out", options->out, "The page to write, such as fingertip.html").required(),
                option("--from-s", options->movie.from_s, "Begin at this time of the scene").within(0, 1e9),
                option("--to-s", options->movie.to_s, "End at this time; 0: with the scene")
                    .within(0, 1e9)
                    .show_default(),
                set_option(options->settings),
                option("--largest-mb", options->movie.largest_mb, "Write no page of more megabytes")
                    .within(0.01, 2000)
                    .show_default(),
                flag("--json", options->json, "Print what was written as JSON"),
            },
        .run = [options] { make_movie(*options); },
    };
}

}  // namespace afferent
