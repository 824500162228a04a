// Text to scene and scene to text: the one place that knows proto/scene.proto.
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <functional>
#include <optional>
#include <set>
#include <span>

#include "afferent/io/files/input_file.hpp"
#include "afferent/io/files/plain_table.hpp"
#include "afferent/scene/kinds.hpp"
#include "afferent/scene/scene_faults.hpp"
#include "afferent/scene/scene_fields.hpp"
#include "afferent/scene/written_scene.hpp"

namespace afferent {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using google::protobuf::TextFormat;

// Scenes are written by hand; what has more bytes is not one.
constexpr std::size_t largest_text = std::size_t{1} << 20;

// Enumerations are read and written by their number.
static_assert(static_cast<int>(scene::OutOfRange::refuse) == proto::REFUSE);
static_assert(static_cast<int>(scene::Between::hold) == proto::Table::HOLD);
static_assert(static_cast<int>(TimeUnit::date) == proto::Table::DATE);
static_assert(static_cast<int>(scene::TableUnit::volts) == proto::Table::VOLTS);
static_assert(static_cast<int>(scene::EmgUnit::volts) == proto::EmgTable::VOLTS);
static_assert(static_cast<int>(scene::EmgSignal::envelope) == proto::EmgTable::ENVELOPE);
static_assert(static_cast<int>(scene::Parts::elements) == proto::Decoder::ELEMENTS);
static_assert(static_cast<int>(RateKind::onset) == proto::ONSET);
static_assert(static_cast<int>(Rounding::truncation) == proto::TRUNCATION);
static_assert(static_cast<int>(scene::Form::sparse) == proto::SPARSE);
static_assert(static_cast<int>(scene::Form::dense) == proto::DENSE);
static_assert(static_cast<int>(scene::Encoding::fixed_width) == proto::FIXED_WIDTH);
static_assert(static_cast<int>(scene::DropPolicy::newest) == proto::DROP_NEWEST);
static_assert(static_cast<int>(Pooling::per_neuron) == proto::PER_NEURON);
static_assert(static_cast<int>(EmgGain::Shape::continuous) == proto::CONTINUOUS);
static_assert(static_cast<int>(EmgGain::Doubtful::as_estimated) == proto::AS_ESTIMATED);
static_assert(static_cast<int>(SafeState::open) == proto::OPEN);
static_assert(static_cast<int>(Rearm::by_user) == proto::BY_USER);
static_assert(static_cast<int>(scene::Kind::pc) == proto::PC);
static_assert(static_cast<int>(DiscContact::Tip::flat) == proto::FLAT);
static_assert(static_cast<int>(DiscContact::Tip::sphere) == proto::SPHERE);

template <class T>
inline constexpr bool is_vector = false;
template <class T>
inline constexpr bool is_vector<std::vector<T>> = true;
template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_variant = false;
template <class... T>
inline constexpr bool is_variant<std::variant<T...>> = true;
template <class T>
inline constexpr bool is_scalar =
    std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, std::string>;

const FieldDescriptor& field_of(const Message& message, const char* name) {
    return *message.GetDescriptor()->FindFieldByName(name);
}

// Fills a struct from its message; what the message does not say keeps its default.
class Reader {
  public:
    explicit Reader(const Message& message) : message_(message), reflection_(*message.GetReflection()) {}

    template <class T>
    void operator()(const char* name, T& member) const {
        const FieldDescriptor& field = field_of(message_, name);
        if constexpr (is_vector<T>) {
            const int size = reflection_.FieldSize(message_, &field);
            if (size == 0) return;
            member.assign(static_cast<std::size_t>(size), {});
            for (int i = 0; i < size; ++i) read(field, i, member[static_cast<std::size_t>(i)]);
        } else if (reflection_.HasField(message_, &field)) {
            if constexpr (is_optional<T>)
                read(field, -1, *(member = typename T::value_type{}));
            else
                read(field, -1, member);
        }
    }

    template <class Variant>
    void arms(Variant& variant) const {
        arms(variant, std::make_index_sequence<std::variant_size_v<Variant>>());
    }

  private:
    template <class Variant, std::size_t... I>
    void arms(Variant& variant, std::index_sequence<I...>) const {
        (read_arm<I>(variant), ...);
    }

    template <std::size_t I, class Variant>
    void read_arm(Variant& variant) const {
        using Arm = std::variant_alternative_t<I, Variant>;
        const char* name = arm_names<Variant>[I];
        if (!*name) {
            Arm arm;
            each_field(arm, *this);
            if (!(arm == Arm{})) variant = std::move(arm);
            return;
        }
        const FieldDescriptor& field = field_of(message_, name);
        if (!reflection_.HasField(message_, &field)) return;
        variant = Arm{};
        read(field, -1, std::get<I>(variant));
    }

    // The index-th of a repeated field; index -1: the only one.
    template <class T>
    void read(const FieldDescriptor& field, int index, T& value) const {
        if constexpr (is_variant<T>)
            Reader(sub_message(field, index)).arms(value);
        else if constexpr (!is_scalar<T>)
            each_field(value, Reader(sub_message(field, index)));
        else
            value = scalar<T>(field, index);
    }

    const Message& sub_message(const FieldDescriptor& field, int index) const {
        return index < 0 ? reflection_.GetMessage(message_, &field)
                         : reflection_.GetRepeatedMessage(message_, &field, index);
    }

    template <class T>
    T scalar(const FieldDescriptor& field, int index) const {
        const auto get = [&](auto single, auto repeated) {
            return index < 0 ? (reflection_.*single)(message_, &field)
                             : (reflection_.*repeated)(message_, &field, index);
        };
        if constexpr (std::is_same_v<T, bool>)
            return get(&Reflection::GetBool, &Reflection::GetRepeatedBool);
        else if constexpr (std::is_same_v<T, double>)
            return get(&Reflection::GetDouble, &Reflection::GetRepeatedDouble);
        else if constexpr (std::is_same_v<T, std::uint32_t>)
            return get(&Reflection::GetUInt32, &Reflection::GetRepeatedUInt32);
        else if constexpr (std::is_same_v<T, std::uint64_t>)
            return get(&Reflection::GetUInt64, &Reflection::GetRepeatedUInt64);
        else if constexpr (std::is_same_v<T, std::string>)
            return get(&Reflection::GetString, &Reflection::GetRepeatedString);
        else
            return static_cast<T>(get(&Reflection::GetEnumValue, &Reflection::GetRepeatedEnumValue));
    }

    const Message& message_;
    const Reflection& reflection_;
};

// Fills a message from a struct. What has its default is left out; an optional that is there is written
// whatever its value.
class Writer {
  public:
    explicit Writer(Message& message) : message_(message), reflection_(*message.GetReflection()) {}

    template <class T>
    void operator()(const char* name, const T& member) const {
        const FieldDescriptor& field = field_of(message_, name);
        if constexpr (is_vector<T>) {
            for (const auto& value : member) add(field, value);
        } else if constexpr (is_optional<T>) {
            if (member) set(field, *member);
        } else if constexpr (is_scalar<T>) {
            if (member != default_of<T>(field)) set(field, member);
        } else {
            set(field, member);
            if (reflection_.GetMessage(message_, &field).ByteSizeLong() == 0)
                reflection_.ClearField(&message_, &field);
        }
    }

    template <class Variant>
    void arms(const Variant& variant) const {
        const char* name = arm_names<Variant>[variant.index()];
        if (!*name) return std::visit([&](const auto& arm) { each_field(arm, *this); }, variant);
        const FieldDescriptor& field = field_of(message_, name);
        std::visit([&](const auto& arm) { set(field, arm); }, variant);
        const bool is_default =
            variant.index() == 0 && reflection_.GetMessage(message_, &field).ByteSizeLong() == 0;
        if (is_default) reflection_.ClearField(&message_, &field);
    }

  private:
    template <class T>
    static T default_of(const FieldDescriptor& field) {
        if constexpr (std::is_same_v<T, bool>)
            return field.default_value_bool();
        else if constexpr (std::is_same_v<T, double>)
            return field.default_value_double();
        else if constexpr (std::is_same_v<T, std::uint32_t>)
            return field.default_value_uint32();
        else if constexpr (std::is_same_v<T, std::uint64_t>)
            return field.default_value_uint64();
        else if constexpr (std::is_same_v<T, std::string>)
            return field.default_value_string();
        else
            return static_cast<T>(field.default_value_enum()->number());
    }

    template <class T>
    void fill(Message& message, const T& value) const {
        if constexpr (is_variant<T>)
            Writer(message).arms(value);
        else
            each_field(value, Writer(message));
    }

    template <class T>
    void set(const FieldDescriptor& field, const T& value) const {
        if constexpr (std::is_same_v<T, bool>)
            reflection_.SetBool(&message_, &field, value);
        else if constexpr (std::is_same_v<T, double>)
            reflection_.SetDouble(&message_, &field, value);
        else if constexpr (std::is_same_v<T, std::uint32_t>)
            reflection_.SetUInt32(&message_, &field, value);
        else if constexpr (std::is_same_v<T, std::uint64_t>)
            reflection_.SetUInt64(&message_, &field, value);
        else if constexpr (std::is_same_v<T, std::string>)
            reflection_.SetString(&message_, &field, value);
        else if constexpr (std::is_enum_v<T>)
            reflection_.SetEnumValue(&message_, &field, static_cast<int>(value));
        else
            fill(*reflection_.MutableMessage(&message_, &field), value);
    }

    template <class T>
    void add(const FieldDescriptor& field, const T& value) const {
        if constexpr (std::is_same_v<T, double>)
            reflection_.AddDouble(&message_, &field, value);
        else if constexpr (std::is_same_v<T, std::uint32_t>)
            reflection_.AddUInt32(&message_, &field, value);
        else if constexpr (std::is_same_v<T, std::string>)
            reflection_.AddString(&message_, &field, value);
        else
            fill(*reflection_.AddMessage(&message_, &field), value);
    }

    Message& message_;
    const Reflection& reflection_;
};

// ---- messages ----

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

// ---- places ----

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

struct Place {
    TextFormat::ParseLocation at;
    bool exact;
};

// The place of the field, or of the last field on the way to it that was written.
std::optional<Place> find(const TextFormat::ParseInfoTree* tree, std::string_view path) {
    const Descriptor* type = proto::Scene::descriptor();
    std::optional<Place> found;
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
    std::optional<Place> place = find(&tree, path);
    if (path.starts_with("patch[") && !(place && place->exact)) {
        const auto shared = find(&tree, "every_patch" + path.substr(path.find(']') + 1));
        if (shared && (shared->exact || !place)) place = shared;
    }
    if (!place) return "1:1";
    return std::to_string(place->at.line + 1) + ":" + std::to_string(place->at.column + 1);
}

// ---- what only the text has ----

proto::Patch preset_of(const proto::Patch& patch) {
    proto::Patch filled;
    if (!patch.has_kind()) return filled;
    const scene::Patch of_kind = scene::preset(static_cast<scene::Kind>(patch.kind()));
    each_field(of_kind, Writer(filled));
    return filled;
}

// The patch with what it does not say itself taken from every_patch, and what neither says from their kind. A
// list of its own replaces the shared one.
proto::Patch filled_in(const proto::Patch& shared, const proto::Patch& own) {
    proto::Patch patch = preset_of(own.has_kind() ? own : shared);
    patch.MergeFrom(shared);
    if (own.spread().time_class_size()) patch.mutable_spread()->clear_time_class();
    // Either way of giving places replaces the other.
    if (own.afferents().place_size() || own.afferents().has_places()) {
        patch.mutable_afferents()->clear_place();
        patch.mutable_afferents()->clear_places();
    }
    if (own.share_size()) patch.clear_share();
    if (own.field_size()) patch.clear_field();
    if (own.sensor().calibration_size()) patch.mutable_sensor()->clear_calibration();
    if (own.sensor().dead_element_size()) patch.mutable_sensor()->clear_dead_element();
    if (own.sensor().stuck_element_size()) patch.mutable_sensor()->clear_stuck_element();
    // The patch whose elements it reads has the sensor and the outline.
    if (own.has_elements_of()) {
        patch.clear_sensor();
        patch.clear_outline();
    }
    patch.MergeFrom(own);
    patch.clear_kind();
    patch.clear_kinds();
    patch.clear_per_cm2();
    return patch;
}

// One patch for each of its kinds, or the patch itself.
std::vector<proto::Patch> one_of_each_kind(const proto::Patch& shared, const proto::Patch& own) {
    const auto& kinds = own.kinds_size() ? own.kinds() : shared.kinds();
    const auto& per_cm2 = own.per_cm2_size() ? own.per_cm2() : shared.per_cm2();
    if (kinds.empty() || own.has_kind()) return {own};
    std::vector<proto::Patch> patches;
    for (int i = 0; i < kinds.size(); ++i) {
        proto::Patch patch = own;
        const auto kind = static_cast<proto::Kind>(kinds[i]);
        patch.set_kind(kind);
        patch.set_name(own.name() + (own.name().empty() ? "" : " ") + proto::Kind_Name(kind));
        if (i < per_cm2.size()) patch.mutable_afferents()->set_per_cm2(per_cm2[i]);
        if (i > 0 && !own.has_elements_of()) {
            patch.clear_elements();
            patch.clear_share();
            patch.clear_outline();
            patch.clear_sensor();
            patch.set_elements_of(patches.front().name());
        }
        patches.push_back(std::move(patch));
    }
    return patches;
}

// What is wrong with the kinds of a patch, and the field that it is about.
std::optional<std::pair<std::string, std::string>> wrong_kinds(const proto::Patch& shared,
                                                               const proto::Patch& own) {
    const int kinds = own.kinds_size() ? own.kinds_size() : shared.kinds_size();
    const int densities = own.per_cm2_size() ? own.per_cm2_size() : shared.per_cm2_size();
    if (own.kinds_size() && own.has_kind()) return std::pair("kinds", "a patch has either a kind or kinds");
    if (densities && densities != kinds && !own.has_kind())
        return std::pair("per_cm2", "per_cm2 must be given once for each of the " + std::to_string(kinds) +
                                        " kinds, is given " + std::to_string(densities) + " times");
    return std::nullopt;
}

bool has_stimuli(const proto::Source& source) {
    return source.has_skin() || source.edge_size() + source.indenter_size() + source.grating_size() +
                                        source.texture_size() + source.grasp_size() >
                                    0;
}

// Puts the places of a table into the patch, so that a scene, and a recording with it, stands alone. Returns
// what is wrong with the table.
std::optional<std::string> read_places(proto::Patch& patch, const std::filesystem::path& folder) {
    if (!patch.afferents().has_places()) return std::nullopt;
    proto::Afferents& afferents = *patch.mutable_afferents();
    if (afferents.place_size()) return "afferents: either place or places";
    const auto table = read_plain_table(folder / afferents.places(), {"x_mm", "y_mm"});
    if (const auto* error = std::get_if<TableError>(&table)) return error->message();
    const auto& values = std::get<std::vector<double>>(table);
    for (std::size_t i = 0; i < values.size(); i += 2) {
        proto::Point& place = *afferents.add_place();
        place.set_x_mm(values[i]);
        place.set_y_mm(values[i + 1]);
    }
    afferents.clear_places();
    return std::nullopt;
}

// Where each patch of the scene was written, as its index there.
using Written = std::vector<std::size_t>;

Written resolve_shorthands(proto::Scene& scene) {
    if (scene.has_every_patch() && scene.patch_size() == 0)
        for (const scene::Patch& patch : Scene().patches) scene.add_patch()->set_name(patch.name);
    proto::Scene resolved;
    Written written;
    for (int i = 0; i < scene.patch_size(); ++i)
        for (const proto::Patch& patch : one_of_each_kind(scene.every_patch(), scene.patch(i))) {
            *resolved.add_patch() = filled_in(scene.every_patch(), patch);
            written.push_back(static_cast<std::size_t>(i));
        }
    scene.mutable_patch()->Swap(resolved.mutable_patch());
    scene.clear_every_patch();
    if (scene.decoder().has_window_ms()) {
        const double window_ms = scene.decoder().window_ms();
        scene.mutable_decoder()->clear_window_ms();
        if (scene.decoder().kind_case() == proto::Decoder::KIND_NOT_SET)
            scene.mutable_decoder()->mutable_sliding_window()->set_window_ms(window_ms);
    }
    return written;
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
