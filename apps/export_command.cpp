// afferent export: the neurons of a scene for a chip, and the vectors that they are held to.
#include <filesystem>
#include <fstream>
#include <memory>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/print_at_once.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/chip/c_export.hpp"
#include "afferent/chip/vectors.hpp"
#include "afferent/chip/verilog_export.hpp"
#include "afferent/io/files/results_folder.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

constexpr const char* vectors_file = "vectors.txt";

struct ExportOptions {
    SceneOptions scene;
    std::string c;
    std::string verilog;
    std::string vectors;
    bool json = false;
};

// Files of those names replace what is there: that has to be an earlier export's.
void write_files(const std::filesystem::path& folder, const std::vector<ExportedFile>& files,
                 const ChipNeurons& neurons, const Vectors& vectors) {
    std::vector<std::string> names{vectors_file};
    for (const ExportedFile& file : files) names.push_back(file.name);
    std::error_code error;
    for (const std::string& name : names)
        if (std::filesystem::exists(folder / name, error) &&
            !std::filesystem::exists(folder / vectors_file, error))
            throw Failure((folder / name).string() +
                          " is there, and of no earlier export: choose another folder");
    ResultsFolder results = value_or_fail(ResultsFolder::create(folder, names));
    const auto written = [&](const std::string& name, const auto& write_to) {
        std::ofstream out(results.unfinished() / name, std::ios::binary);
        write_to(out);
        if (!out.flush()) throw Failure((folder / name).string() + ": cannot be written");
    };
    written(vectors_file, [&](std::ostream& out) { write(vectors, neurons.count(), out); });
    for (const ExportedFile& file : files) written(file.name, [&](std::ostream& out) { out << file.text; });
    value_or_fail(results.put_in_place());
}

void export_chip(const ExportOptions& options) {
    if (options.c.empty() && options.verilog.empty() && options.vectors.empty())
        throw Failure("--c, --verilog or --vectors: say what is to be exported, and where to");
    if (!options.c.empty() && options.c == options.verilog)
        throw Failure("--c and --verilog: choose two folders, since each has a Makefile of its own");
    const Scene scene = options.scene.read_to_run();
    const ChipNeurons neurons = chip_neurons(make_plan(scene));
    const auto vectors_of = [&](const VectorLength& length) {
        Progress progress("trying each neuron");
        return chip_vectors(neurons, scene.seed, length, [&](double part) { progress.at(part); });
    };
    Vectors vectors;
    if (!options.verilog.empty()) {
        vectors = vectors_of(VectorLength::of_simulation(neurons));
        write_files(options.verilog, export_verilog(neurons, scene.name), neurons, vectors);
    }
    if (!options.c.empty() || !options.vectors.empty()) vectors = vectors_of(VectorLength::full(neurons));
    if (!options.c.empty()) write_files(options.c, export_c(neurons, scene.name), neurons, vectors);
    if (!options.vectors.empty()) write_files(options.vectors, {}, neurons, vectors);

    Summary summary;
    summary["neurons"] = neurons.count();
    summary["tick_us"] = static_cast<double>(neurons.tick_ns) / 1000;
    summary["product_bits"] = chip_widths(neurons).product_bits;
    if (!options.verilog.empty()) summary["cycles_per_tick"] = exported_cycles_per_tick(neurons);
    summary["bytes_per_neuron"] = exported_bytes_per_neuron(neurons);
    summary["vector_ticks"] = vectors.ticks;
    summary["vector_records"] = vectors.records.size();
    print(summary, options.json);
    for (const std::string& folder : {options.c, options.verilog})
        if (!folder.empty()) say("written to " + folder + "; make -C " + folder + " test checks it");
    if (!options.vectors.empty()) say("written to " + options.vectors + "/" + vectors_file);
}

}  // namespace

Command export_command() {
    const auto options = std::make_shared<ExportOptions>();
    return {
        .name = "export",
        .help = "Write a scene's neurons as C or Verilog, equal to the emulator to the bit",
        .footer =
            "The scene's neurons have to be neuron { fixed_point {} }.\n"
            "Example:\n  afferent export examples/chip.txtpb --c out/chip\n  make -C out/chip test",
        .options = options->scene.followed_by({
            option("--c", options->c, "Folder for the neurons in C99, with their vectors and a check"),
            option("--verilog", options->verilog,
                   "Folder for a core in synthesizable Verilog, with its vectors and a test bench"),
            option("--vectors", options->vectors,
                   "Folder for the vectors alone: inputs, and the events and states that follow"),
            flag("--json", options->json, "Print the summary as JSON"),
        }),
        .run = [options] { export_chip(*options); },
    };
}

}  // namespace afferent
