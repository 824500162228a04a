// afferent export: the neurons of a scene for a chip, and the vectors that they are held to.
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/print_at_once.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/chip/c_export.hpp"
#include "afferent/chip/scene_vectors.hpp"
#include "afferent/chip/vectors.hpp"
#include "afferent/chip/verilog_export.hpp"
#include "afferent/io/files/results_folder.hpp"
#include "afferent/nodes/run.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

constexpr const char* vectors_file = "vectors.txt";
constexpr const char* scene_file = "scene.txt";

struct ExportOptions {
    SceneOptions scene;
    std::string c;
    std::string verilog;
    std::string vectors;
    bool json = false;
};

// What the scene's own run reads and fires; nothing where the chip cannot have that, or the run comes but
// once.
std::optional<ExportedFile> scene_vectors(const Plan& plan, const ChipNeurons& neurons,
                                          const ChipParts& parts) {
    if (!parts.encoder || !parts.wire || traits_of(plan.scene.source).once) return std::nullopt;
    SceneVectors scene(plan, neurons, parts);
    Observer observer;
    observer.scan = [&](const Scan& scan) { scene.take(scan); };
    observer.events = [&](std::span<const Event> events) { scene.take(events); };
    const auto run = value_or_fail(Run::open(plan, observer));
    Progress progress("running the scene");
    for (; !run->done(); progress.at(seconds(run->next()) / seconds(plan.end())))
        value_or_fail(run->do_next());
    run->finish(plan.end());
    std::ostringstream out;
    write(scene.vectors(plan.end()), neurons.count(), out);
    return ExportedFile{scene_file, out.str()};
}

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
    std::set<std::filesystem::path> folders;
    for (const std::string& folder : {options.c, options.verilog, options.vectors})
        if (!folder.empty() &&
            !folders.insert(std::filesystem::weakly_canonical(std::filesystem::absolute(folder) / "")).second)
            throw Failure(
                "--c, --verilog, --vectors: choose a folder for each, since each has a Makefile of its own");
    const Scene scene = options.scene.read_to_run();
    const Plan plan = make_plan(scene);
    const ChipNeurons neurons = chip_neurons(plan);
    const ChipParts parts = chip_parts(plan, neurons);
    const auto vectors_of = [&](const ChipParts& of, const VectorLength& length) {
        Progress progress("trying each neuron");
        return chip_vectors(neurons, of, scene.seed, length, [&](double part) { progress.at(part); });
    };
    Vectors vectors;
    if (!options.verilog.empty()) {
        vectors = vectors_of({}, VectorLength::of_simulation(neurons));
        write_files(options.verilog, export_verilog(neurons, scene.name), neurons, vectors);
    }
    if (!options.c.empty() || !options.vectors.empty())
        vectors = vectors_of(parts, VectorLength::full(neurons));
    if (!options.c.empty()) {
        std::vector<ExportedFile> files = export_c(neurons, parts, scene.name);
        if (auto file = scene_vectors(plan, neurons, parts)) files.push_back(std::move(*file));
        write_files(options.c, files, neurons, vectors);
    }
    if (!options.vectors.empty())
        write_files(options.vectors, export_vectors(neurons, scene.name), neurons, vectors);

    Summary summary;
    summary["neurons"] = neurons.count();
    summary["tick_us"] = static_cast<double>(neurons.tick_ns) / 1000;
    summary["product_bits"] = chip_widths(neurons).product_bits;
    if (!options.verilog.empty()) summary["cycles_per_tick"] = exported_cycles_per_tick(neurons);
    summary["bytes_per_neuron"] = exported_bytes_per_neuron(neurons);
    summary["vector_ticks"] = vectors.ticks;
    summary["vector_records"] = vectors.records.size();
    print(summary, options.json);
    if (!options.c.empty() && !parts.encoder) say("without the encoder: " + parts.why_no_encoder);
    if (!options.c.empty() && !parts.wire) say("without the packets: " + parts.why_no_wire);
    for (const std::string& folder : {options.c, options.verilog})
        if (!folder.empty()) say("written to " + folder + "; make -C " + folder + " test checks it");
    if (!options.vectors.empty())
        say("written to " + options.vectors + "; make -C " + options.vectors +
            " test checks yours.txt there");
}

}  // namespace

Command export_command() {
    const auto options = std::make_shared<ExportOptions>();
    return {
        .name = "export",
        .help =
            "Write a scene's coprocessor as C, or its neurons as Verilog, equal to the emulator to the bit",
        .footer =
            "The scene's neurons have to be neuron { fixed_point {} }.\n"
            "Example:\n  afferent export examples/chip.txtpb --c out/chip\n  make -C out/chip test",
        .options = options->scene.followed_by({
            option("--c", options->c,
                   "Folder for neurons, encoder and packets in C99, with vectors, a check, a proof and a "
                   "board to try it on"),
            option("--verilog", options->verilog,
                   "Folder for a core in synthesizable Verilog, with its vectors and a test bench"),
            option("--vectors", options->vectors,
                   "Folder for the vectors alone (inputs, and what follows from them) and what compares "
                   "yours with them"),
            flag("--json", options->json, "Print the summary as JSON"),
        }),
        .run = [options] { export_chip(*options); },
    };
}

}  // namespace afferent
