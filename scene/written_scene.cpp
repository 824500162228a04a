#include "afferent/scene/written_scene.hpp"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <memory>
#include <string_view>

#include "afferent/scene/nearest_name.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using google::protobuf::TextFormat;

// What a path has between two dots: "patch[thumb]" is the field "patch" and the item "thumb".
struct NamedStep {
    std::string field;
    std::optional<std::string> item;
};

std::optional<NamedStep> take_named_step(std::string_view& path) {
    std::size_t end = 0;
    // The name of a patch may have dots in it.
    for (bool bracketed = false; end < path.size() && (bracketed || path[end] != '.'); ++end)
        if (path[end] == '[' || path[end] == ']') bracketed = path[end] == '[';
    const std::string_view step = path.substr(0, end);
    path = end == path.size() ? std::string_view() : path.substr(end + 1);
    const std::size_t bracket = step.find('[');
    if (bracket == std::string_view::npos) return NamedStep{std::string(step), std::nullopt};
    if (!step.ends_with(']')) return std::nullopt;
    return NamedStep{std::string(step.substr(0, bracket)),
                     std::string(step.substr(bracket + 1, step.size() - bracket - 2))};
}

std::string quoted_after(const std::string& text, std::string_view before) {
    const std::size_t begin = text.find(before);
    if (begin == std::string::npos) return {};
    const std::size_t name = begin + before.size();
    return text.substr(name, text.find('"', name) - name);
}

std::string no_such_field(const Descriptor& type, const std::string& field) {
    std::vector<std::string> names;
    for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
    std::string text = type.name() + " has no field \"" + field + '"';
    if (const auto nearest = nearest_name(field, names)) text += ": did you mean \"" + *nearest + "\"?";
    return text;
}

bool is_bare_word(std::string_view value) {
    return !value.empty() &&
           value.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string_view::npos;
}

class FirstMessage : public google::protobuf::io::ErrorCollector {
  public:
    void AddError(int, google::protobuf::io::ColumnNumber, const std::string& message) override {
        if (text.empty()) text = message;
    }
    std::string text;
};

class Putter {
  public:
    Putter(std::string_view value, std::vector<std::string>& written) : value_(value), written_(written) {}

    // Puts the value at the rest of the path, which begins in this message.
    std::optional<std::string> put(Message& message, std::string_view path, const std::string& above) {
        const Descriptor& type = *message.GetDescriptor();
        const auto step = take_named_step(path);
        if (!step) return "a bracket is not closed";
        const FieldDescriptor* field = type.FindFieldByName(step->field);
        if (!field) return no_such_field(type, step->field);
        const std::string here = (above.empty() ? "" : above + '.') + step->field;
        if (step->item && !(field->is_repeated() && field->message_type()))
            return step->field + " is not a list of parts: give it whole";
        if (path.empty() && !step->item) {
            written_.push_back(here);
            return put_whole(message, *field);
        }
        if (!field->message_type())
            return path.empty() ? step->field + " is no list of parts" : step->field + " has no fields";
        if (!field->is_repeated())
            return put(*message.GetReflection()->MutableMessage(&message, field), path, here);
        return put_in_items(message, *field, step->item, path, here);
    }

  private:
    std::optional<std::string> put_in_items(Message& message, const FieldDescriptor& field,
                                            const std::optional<std::string>& item, std::string_view path,
                                            const std::string& here) {
        const Reflection& reflection = *message.GetReflection();
        bool found = false;
        for (int i = 0; i < reflection.FieldSize(message, &field); ++i) {
            Message& part = *reflection.MutableRepeatedMessage(&message, &field, i);
            if (item && !is_called(part, i, *item)) continue;
            found = true;
            const std::string part_path = here + '[' + std::to_string(i) + ']';
            if (path.empty()) {
                written_.push_back(part_path);
                if (!value_.starts_with('{') || !value_.ends_with('}')) return "must be a message in braces";
                part.Clear();
                if (auto wrong = merge(part, std::string(value_.substr(1, value_.size() - 2)))) return wrong;
            } else if (auto wrong = put(part, path, part_path)) {
                return wrong;
            }
        }
        if (found) return std::nullopt;
        return item ? "there is no " + field.name() + " \"" + *item + '"' : "there is no " + field.name();
    }

    static bool is_called(const Message& part, int index, const std::string& item) {
        const FieldDescriptor* name = part.GetDescriptor()->FindFieldByName("name");
        if (name && part.GetReflection()->GetString(part, name) == item) return true;
        return item == std::to_string(index);
    }

    std::optional<std::string> put_whole(Message& message, const FieldDescriptor& field) const {
        const Reflection& reflection = *message.GetReflection();
        if (value_.empty()) {
            reflection.ClearField(&message, &field);
            return std::nullopt;
        }
        if (field.type() == FieldDescriptor::TYPE_STRING && !field.is_repeated()) {
            reflection.SetString(&message, &field, std::string(value_));
            return std::nullopt;
        }
        if (field.message_type() && !field.is_repeated()) {
            if (is_bare_word(value_))
                return put_alternative(*reflection.MutableMessage(&message, &field), std::string(value_));
            if (!value_.starts_with('{')) return field.name() + " takes an alternative's name, or {...}";
        }
        if (!field.is_repeated() && field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM &&
            !field.enum_type()->FindValueByName(std::string(value_)))
            return no_such_name(*field.enum_type());
        // A string in a list of one needs no quotes either.
        const bool is_quoted = value_.starts_with('[') || value_.starts_with('"');
        const std::string quote = field.type() == FieldDescriptor::TYPE_STRING && !is_quoted ? "\"" : "";
        const std::unique_ptr<Message> fresh(message.New());
        if (auto wrong = merge(*fresh, field.name() + ": " + quote + std::string(value_) + quote))
            return wrong;
        std::vector<const FieldDescriptor*> fields;
        fresh->GetReflection()->ListFields(*fresh, &fields);
        if (fields.size() > 1) return "must be one value, is " + std::string(value_);
        reflection.ClearField(&message, &field);
        message.MergeFrom(*fresh);
        return std::nullopt;
    }

    // The alternative that is there already keeps its fields.
    static std::optional<std::string> put_alternative(Message& message, const std::string& name) {
        const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(name);
        if (!field || !field->containing_oneof()) {
            std::vector<std::string> names;
            for (int i = 0; i < message.GetDescriptor()->field_count(); ++i)
                if (message.GetDescriptor()->field(i)->containing_oneof())
                    names.push_back(message.GetDescriptor()->field(i)->name());
            return "must be " + one_of(names) + ", is " + name;
        }
        message.GetReflection()->MutableMessage(&message, field);
        return std::nullopt;
    }

    std::string no_such_name(const google::protobuf::EnumDescriptor& type) const {
        std::vector<std::string> names;
        for (int i = 0; i < type.value_count(); ++i) names.push_back(type.value(i)->name());
        return "must be " + one_of(names) + ", is " + std::string(value_);
    }

    static std::string one_of(const std::vector<std::string>& names) {
        if (names.empty()) return "a message in braces";
        std::string text;
        for (std::size_t i = 0; i < names.size(); ++i)
            text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
        return text;
    }

    // `text` is what stands within the message's braces.
    static std::optional<std::string> merge(Message& message, const std::string& text) {
        FirstMessage first;
        TextFormat::Parser parser;
        parser.RecordErrorsTo(&first);
        parser.SetRecursionLimit(deepest_nesting);
        if (parser.MergeFromString(text, &message)) return std::nullopt;
        return with_nearest_name(first.text);
    }

    std::string_view value_;
    std::vector<std::string>& written_;
};

}  // namespace

std::string with_nearest_name(const std::string& message) {
    const std::string field = quoted_after(message, "has no field named \"");
    const Descriptor* type = google::protobuf::DescriptorPool::generated_pool()->FindMessageTypeByName(
        quoted_after(message, "Message type \""));
    return field.empty() || !type ? message : no_such_field(*type, field);
}

Setting Setting::from(std::string_view text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos || equals == 0)
        throw SceneError({"\"" + std::string(text) +
                          "\" is no setting: give a field's path and its value, as in neuron.delta_g=0.1"});
    return {std::string(text.substr(0, equals)), std::string(text.substr(equals + 1))};
}

std::optional<std::string> put(proto::Scene& scene, const Setting& setting,
                               std::vector<std::string>& written) {
    Putter putter(setting.value, written);
    std::string_view rest = setting.path;
    const auto first = take_named_step(rest);
    const bool of_patches = first && !proto::Scene::descriptor()->FindFieldByName(first->field) &&
                            proto::Patch::descriptor()->FindFieldByName(first->field);
    const std::string path = of_patches ? "patch." + setting.path : setting.path;
    if (path.starts_with("patch[") && scene.patch_size() == 0)
        for (const scene::Patch& patch : Scene().patches) scene.add_patch()->set_name(patch.name);
    if (!path.starts_with("patch.")) return putter.put(scene, path, "");
    // Patches that the text does not name take it from every_patch.
    if (scene.patch_size() == 0) return putter.put(scene, "every_" + path, "");
    for (int i = 0; i < scene.patch_size(); ++i) {
        // The patch whose elements it reads has the sensor and the outline.
        if (scene.patch(i).has_elements_of() && first &&
            (path.starts_with("patch.sensor") || path.starts_with("patch.outline")))
            continue;
        const std::string item = "patch[" + std::to_string(i) + "]";
        if (auto wrong = putter.put(*scene.mutable_patch(i), path.substr(6), item)) return wrong;
    }
    return std::nullopt;
}

}  // namespace afferent
