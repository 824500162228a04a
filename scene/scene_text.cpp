#include "afferent/scene/scene_text.hpp"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <charconv>
#include <optional>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::TextFormat;

constexpr int deepest_nesting = 16;

std::string joined(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + line;
    return text;
}

class Collector : public google::protobuf::io::ErrorCollector {
  public:
    Collector(const std::string& name, std::vector<std::string>& messages)
        : name_(name), messages_(messages) {}

    void AddError(int line, google::protobuf::io::ColumnNumber column, const std::string& message) override {
        messages_.push_back(name_ + ":" + std::to_string(line + 1) + ":" + std::to_string(column + 1) + ": " +
                            message);
    }

  private:
    const std::string& name_;
    std::vector<std::string>& messages_;
};

// One step of a path: "patch[1]" is field "patch", index 1; a field that is not repeated has index -1.
struct Step {
    std::string field;
    int index = -1;
};

Step take_step(std::string_view& path) {
    const std::size_t dot = path.find('.');
    std::string_view step = path.substr(0, dot);
    path = dot == std::string_view::npos ? std::string_view() : path.substr(dot + 1);
    Step taken{std::string(step.substr(0, step.find('['))), -1};
    if (const std::size_t bracket = step.find('['); bracket != std::string_view::npos)
        std::from_chars(step.data() + bracket + 1, step.data() + step.size(), taken.index);
    return taken;
}

struct Place {
    TextFormat::ParseLocation at;
    bool exact;
};

// The place of the field, or of the last field on the way to it that was written.
std::optional<Place> find(const TextFormat::ParseInfoTree* tree, const google::protobuf::Descriptor* type,
                          std::string_view path) {
    std::optional<Place> found;
    while (tree && type && !path.empty()) {
        Step step = take_step(path);
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

}  // namespace

SceneError::SceneError(std::vector<std::string> messages)
    : std::runtime_error(joined(messages)), messages_(std::move(messages)) {}

SceneText::SceneText(std::string_view text, std::string name) : name_(std::move(name)) {
    if (text.size() > largest_scene_text)
        throw SceneError({name_ + ": a scene has at most " + std::to_string(largest_scene_text) +
                          " bytes, this has " + std::to_string(text.size())});
    Collector collector(name_, messages_);
    TextFormat::Parser parser;
    parser.RecordErrorsTo(&collector);
    parser.WriteLocationsTo(&places_);
    parser.SetRecursionLimit(deepest_nesting);
    google::protobuf::io::ArrayInputStream stream(text.data(), static_cast<int>(text.size()));
    const bool parsed = parser.Parse(&stream, &scene_);
    if (!parsed && messages_.empty()) messages_.push_back(name_ + ": not a scene");
    throw_if_refused();
}

std::string SceneText::where(std::string_view path) const {
    const auto* type = proto::Scene::descriptor();
    std::optional<Place> place = find(&places_, type, path);
    if (path.starts_with("patch[") && !(place && place->exact)) {
        const std::string shared = "every_patch" + std::string(path.substr(path.find(']') + 1));
        const std::optional<Place> elsewhere = find(&places_, type, shared);
        if (elsewhere && (elsewhere->exact || !place)) place = elsewhere;
    }
    if (!place) return name_ + ":1:1";
    return name_ + ":" + std::to_string(place->at.line + 1) + ":" + std::to_string(place->at.column + 1);
}

void SceneText::check(const std::string& path, const std::string& about, const std::function<void()>& rule) {
    try {
        rule();
    } catch (const ParameterError& error) {
        // "patch[1].neuron" is called "neuron" after the patch's name.
        const std::string inner =
            about.empty() ? path : path.substr(std::min(path.find('.') + 1, path.size()));
        messages_.push_back(where(path + "." + error.field()) + ": " + (about.empty() ? "" : about + ": ") +
                            inner + (inner.empty() ? "" : ".") + error.what());
    }
}

void SceneText::refuse(const std::string& path, const std::string& text) {
    messages_.push_back(where(path) + ": " + text);
}

void SceneText::throw_if_refused() const {
    if (!messages_.empty()) throw SceneError(messages_);
}

}  // namespace afferent
