// Text to scene and scene to text: the one place that knows proto/scene.proto.
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <functional>
#include <optional>
#include <set>
#include <span>

#include "afferent/io/files/input_file.hpp"
#include "afferent/io/files/table.hpp"
#include "afferent/scene/scene_faults.hpp"
#include "afferent/scene/scene_message.hpp"
#include "afferent/scene/shorthands.hpp"
#include "afferent/scene/written_scene.hpp"

namespace afferent {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::TextFormat;

// Scenes are written by hand; what has more bytes is not one.
constexpr std::size_t largest_text = std::size_t{1} << 20;

// Enumerations are read and written by their number.
static_assert(static_cast<int>(scene::OutOfRange::refuse) == proto::REFUSE);
static_assert(static_cast<int>(scene::Between::hold) == proto::Table::HOLD);
static_assert(static_cast<int>(TimeUnit::month_first) == proto::Table::DATE_MONTH_FIRST);
static_assert(static_cast<int>(Missing::interpolate) == proto::Table::INTERPOLATE);
static_assert(static_cast<int>(scene::TableUnit::volts) == proto::Table::VOLTS);
static_assert(static_cast<int>(scene::EmgUnit::volts) == proto::EmgTable::VOLTS);
static_assert(static_cast<int>(scene::EmgSignal::envelope) == proto::EmgTable::ENVELOPE);
static_assert(static_cast<int>(scene::Parts::elements) == proto::Decoder::ELEMENTS);
static_assert(static_cast<int>(RateKind::onset) == proto::ONSET);
static_assert(static_cast<int>(Rounding::truncation) == proto::TRUNCATION);
static_assert(static_cast<int>(scene::Form::sparse) == proto::SPARSE);
static_assert(static_cast<int>(scene::Form::dense) == proto::DENSE);
static_assert(static_cast<int>(scene::Encoding::predicted) == proto::PREDICTED);
static_assert(static_cast<int>(scene::DropPolicy::newest) == proto::DROP_NEWEST);
static_assert(static_cast<int>(Pooling::per_neuron) == proto::PER_NEURON);
static_assert(static_cast<int>(EmgGain::Shape::continuous) == proto::CONTINUOUS);
static_assert(static_cast<int>(EmgGain::Doubtful::as_estimated) == proto::AS_ESTIMATED);
static_assert(static_cast<int>(SafeState::open) == proto::OPEN);
static_assert(static_cast<int>(Rearm::by_user) == proto::BY_USER);
static_assert(static_cast<int>(scene::Kind::pc) == proto::PC);
static_assert(static_cast<int>(scene::Kind::sa1_dynamic) == proto::SA1_DYNAMIC);
static_assert(static_cast<int>(IndenterTip::flat) == proto::FLAT);
static_assert(static_cast<int>(IndenterTip::sphere) == proto::SPHERE);

class Collector : public google::protobuf::io::ErrorCollector {
  public:
    Collector(const std::string& file, std::vector<std::string>& messages)
        : file_(file), messages_(messages) {}

    void AddError(int line, google::protobuf::io::ColumnNumber column, const std::string& message) override {
        messages_.push_back(file_ + ":" + std::to_string(line + 1) + ":" + std::to_string(column + 1) + ": " +
                            with_nearest_name(message));
    }

  private:
    const std::string& file_;
    std::vector<std::string>& messages_;
};

// One step of a path: "patch[1]" is field "patch", index 1; a field that is not repeated has index -1.
struct PathStep {
    std::string field;
    int index = -1;
};

PathStep take_step(std::string_view& path) {
    const std::size_t dot = path.find('.');
    const std::string_view step = path.substr(0, dot);
    path = dot == std::string_view::npos ? std::string_view() : path.substr(dot + 1);
    PathStep taken{std::string(step.substr(0, step.find('['))), -1};
    if (const std::size_t bracket = step.find('['); bracket != std::string_view::npos)
        std::from_chars(step.data() + bracket + 1, step.data() + step.size(), taken.index);
    return taken;
}

struct Position {
    TextFormat::ParseLocation at;
    bool exact;
};

// The place of the field, or of the last field on the way to it that was written.
std::optional<Position> find(const TextFormat::ParseInfoTree* tree, std::string_view path) {
    const Descriptor* type = proto::Scene::descriptor();
    std::optional<Position> found;
    while (tree && type && !path.empty()) {
        PathStep step = take_step(path);
        const FieldDescriptor* field = type->FindFieldByName(step.field);
        if (!field) break;
        if (field->is_repeated() && step.index < 0) step.index = 0;
        const auto at = tree->GetLocation(field, step.index);
        if (at.line < 0) break;
        found = {at, path.empty()};
        tree = field->message_type() ? tree->GetTreeForNested(field, step.index) : nullptr;
        type = field->message_type();
    }
    return found;
}

// As "line:column". What a patch does not say itself is looked for in every_patch.
std::string place_of(const TextFormat::ParseInfoTree& tree, const std::string& path) {
    std::optional<Position> place = find(&tree, path);
    if (path.starts_with("patch[") && !(place && place->exact)) {
        const auto shared = find(&tree, "every_patch" + path.substr(path.find(']') + 1));
        if (shared && (shared->exact || !place)) place = shared;
    }
    if (!place) return "1:1";
    return std::to_string(place->at.line + 1) + ":" + std::to_string(place->at.column + 1);
}

// The path in the text of a path in the scene.
std::string written_path(const std::string& path, const Written& written) {
    if (!path.starts_with("patch[")) return path;
    std::string_view rest = path;
    const auto index = static_cast<std::size_t>(take_step(rest).index);
    return patch_path(index < written.size() ? written[index] : index) + path.substr(path.find(']') + 1);
}

// The setting that has written the field of that path, or a part of it.
const Setting* setting_of(const std::string& path, std::span<const Setting> settings,
                          const std::vector<std::vector<std::string>>& paths) {
    const std::string shared =
        path.starts_with("patch[") ? "every_patch" + path.substr(path.find(']') + 1) : path;
    for (std::size_t i = settings.size(); i-- > 0;)
        for (const std::string& put : paths[i])
            for (const std::string& each : {path, shared})
                if (each.starts_with(put) || put.starts_with(each + '.')) return &settings[i];
    return nullptr;
}

// Resolves and checks what is written. `place` tells where a field stands in the text, as "FILE:LINE:COLUMN".
Scene read(proto::Scene written, std::string file, std::filesystem::path folder,
           std::span<const Setting> settings, const std::function<std::string(const std::string&)>& place) {
    std::vector<std::string> messages;
    std::vector<std::vector<std::string>> paths(settings.size());
    for (std::size_t i = 0; i < settings.size(); ++i)
        if (const auto wrong = put(written, settings[i], paths[i]))
            messages.push_back(settings[i].text() + ": " + *wrong);
    const auto stop_if_wrong = [&] {
        if (!messages.empty()) throw SceneError(std::move(messages));
    };
    stop_if_wrong();

    // A fault in every_patch is one in each patch, and is told once.
    std::set<std::string> told;
    const auto refuse = [&](const std::string& path, const std::string& why, const std::string& about = {}) {
        const Setting* setting = setting_of(path, settings, paths);
        const std::string where = setting ? setting->text() : place(path);
        if (told.insert(where + why).second)
            messages.push_back(where + ": " + (about.empty() ? "" : about + ": ") + why);
    };
    if (has_stimuli(written.source()) && written.source().kind_case() != proto::Source::KIND_NOT_SET)
        refuse("source", "source: samples come either from stimuli on the skin or from elsewhere");
    for (int i = 0; i < written.patch_size(); ++i)
        if (const auto wrong = wrong_kinds(written.every_patch(), written.patch(i)))
            refuse(patch_path(static_cast<std::size_t>(i)) + "." + wrong->first, wrong->second,
                   about_patch(written.patch(i).name()));
    stop_if_wrong();
    const Written patches = resolve_shorthands(written);
    for (int i = 0; i < written.patch_size(); ++i)
        if (const auto wrong = read_places(*written.mutable_patch(i), folder))
            refuse(written_path(patch_path(static_cast<std::size_t>(i)) + ".afferents.places", patches),
                   *wrong);
    stop_if_wrong();
    Scene scene;
    each_field(scene, Reader(written));
    scene.file = std::move(file);
    scene.folder = std::move(folder);
    for (const SceneFault& fault : faults_of(scene))
        refuse(written_path(fault.path, patches), fault.text, fault.about);
    stop_if_wrong();
    return scene;
}

bool is_named_as_table(const std::filesystem::path& file) {
    const std::string ending = file.extension().string();
    constexpr std::array others{".csv", ".tsv",     ".gz",      ".xlsx", ".xls",
                                ".ods", ".parquet", ".feather", ".tdms"};
    return is_container(file) || std::ranges::find(others, ending) != others.end();
}

}  // namespace

Scene Scene::from_text(std::string_view text, std::string file, std::filesystem::path folder,
                       std::span<const Setting> settings) {
    if (text.size() > largest_text)
        throw SceneError({file + ": a scene has at most " + std::to_string(largest_text) +
                          " bytes, this has " + std::to_string(text.size())});
    std::vector<std::string> messages;
    Collector collector(file, messages);
    TextFormat::ParseInfoTree places;
    TextFormat::Parser parser;
    parser.RecordErrorsTo(&collector);
    parser.WriteLocationsTo(&places);
    parser.SetRecursionLimit(deepest_nesting);
    google::protobuf::io::ArrayInputStream stream(text.data(), static_cast<int>(text.size()));
    proto::Scene written;
    if (!parser.Parse(&stream, &written) && messages.empty()) messages.push_back(file + ": not a scene");
    if (!messages.empty()) throw SceneError(std::move(messages));
    return read(std::move(written), file, std::move(folder), settings,
                [&](const std::string& path) { return file + ":" + place_of(places, path); });
}

Scene Scene::from_file(const std::filesystem::path& file, std::span<const Setting> settings) {
    if (is_named_as_table(file))
        throw SceneError({file.string() + ": a table, and no scene. A scene for it: afferent inspect " +
                          file.string() + " --scene scene.txtpb"});
    const Result<InputFile> in = open_input(file);
    if (!in) throw SceneError({in.error().text});
    std::string text(largest_text + 1, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), in.value().get()));
    if (std::ferror(in.value().get()) != 0) throw SceneError({file.string() + ": cannot be read"});
    return from_text(text, file.string(), file.parent_path(), settings);
}

Scene Scene::with(std::span<const Setting> settings) const {
    proto::Scene written;
    each_field(*this, Writer(written));
    return read(std::move(written), file, folder, settings, [](const std::string& path) { return path; });
}

std::string Scene::text(TextLayout layout) const {
    proto::Scene message;
    each_field(*this, Writer(message));
    if (patches == Scene().patches) message.clear_patch();
    TextFormat::Printer printer;
    printer.SetSingleLineMode(layout == TextLayout::one_line);
    std::string text;
    printer.PrintToString(message, &text);
    return text;
}

}  // namespace afferent
