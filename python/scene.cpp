// The scene and its plan.
#include <pybind11/operators.h>

#include "afferent/python/bindings.hpp"
#include "afferent/scene/population.hpp"
#include "afferent/scene/scene_schema.hpp"
#include "afferent/scene/scene_table.hpp"

namespace afferent::python {
namespace {

using Path = std::filesystem::path;

const char* name(SchemaField::Type type) {
    switch (type) {
        case SchemaField::Type::number:
            return "number";
        case SchemaField::Type::whole_number:
            return "whole number";
        case SchemaField::Type::boolean:
            return "boolean";
        case SchemaField::Type::text:
            return "text";
        case SchemaField::Type::name:
            return "name";
        case SchemaField::Type::message:
            return "message";
    }
    return "";
}

// Tuples of a message's name and its fields: name, type, repeated, alternative, of, names.
py::list schema() {
    py::list messages;
    for (const SchemaMessage& message : scene_schema()) {
        py::list fields;
        for (const SchemaField& field : message.fields)
            fields.append(py::make_tuple(field.name, name(field.type), field.repeated, field.alternative,
                                         field.of, field.names));
        messages.append(py::make_tuple(message.name, fields));
    }
    return messages;
}

std::vector<Setting> settings_of(const std::vector<std::pair<std::string, std::string>>& given) {
    std::vector<Setting> settings;
    for (const auto& [path, value] : given) settings.push_back({path, value});
    return settings;
}

std::string text(const Scene& scene, bool lines) {
    return scene.text(lines ? Scene::TextLayout::field_a_line : Scene::TextLayout::one_line);
}

}  // namespace

void bind_scene(py::module_& module) {
    module.def("schema", schema);

    py::class_<Scene>(module, "Scene")
        .def(py::init([](const std::string& text, std::string file, Path folder) {
                 return Scene::from_text(text, std::move(file), std::move(folder));
             }),
             py::arg("text"), py::arg("file"), py::arg("folder"))
        .def(py::init<const Scene&>(), py::arg("scene"))
        .def_static(
            "read", [](const Path& file) { return Scene::from_file(file); }, py::arg("file"))
        .def(
            "with_settings",
            [](const Scene& scene, const std::vector<std::pair<std::string, std::string>>& settings) {
                return scene.with(settings_of(settings));
            },
            py::arg("settings"))
        .def("check", &Scene::check)
        .def("text", text, py::arg("lines") = false)
        .def("fingerprint", &Scene::fingerprint)
        .def_property_readonly("name", [](const Scene& scene) { return scene.name; })
        .def_property_readonly("duration_s",
                               [](const Scene& scene) {
                                   return scene.duration_s ? *scene.duration_s : default_duration_s(scene);
                               })
        .def_property_readonly("seed", [](const Scene& scene) { return scene.seed; })
        .def_property_readonly("file", [](const Scene& scene) { return scene.file; })
        .def_property_readonly("folder", [](const Scene& scene) { return scene.folder; });

    py::class_<PlanItem>(module, "PlanItem")
        .def_readonly("name", &PlanItem::name)
        .def_readonly("built", &PlanItem::built)
        .def_readonly("reason", &PlanItem::reason)
        .def("__repr__", [](const PlanItem& part) {
            return part.name + (part.built ? ": built: " : ": left out: ") + part.reason;
        });

    py::class_<Plan, std::shared_ptr<Plan>>(module, "Plan")
        .def(py::init([](const Scene& scene) {
                 const py::gil_scoped_release unlocked;
                 return std::make_shared<Plan>(make_plan(scene));
             }),
             py::arg("scene"))
        .def_property_readonly("elements", [](const Plan& plan) { return plan.elements; })
        .def_property_readonly("neurons", [](const Plan& plan) { return plan.addresses; })
        .def_readonly("threads", &Plan::threads)
        .def_readonly("bytes_per_neuron", &Plan::bytes_per_neuron)
        .def_readonly("bytes_per_element", &Plan::bytes_per_element)
        .def_readonly("events_per_second_at_most", &Plan::events_per_second)
        .def_readonly("bytes_per_second_at_most", &Plan::bytes_per_second)
        .def_readonly("bytes_per_second_at_rest", &Plan::resting_bytes_per_second)
        .def_property_readonly("latency_ms_at_most",
                               [](const Plan& plan) { return Milliseconds(plan.latency.most()).count(); })
        .def_readonly("items", &Plan::items)
        .def("population", [](const Plan& plan) {
            py::dict result;
            add_population(result, population_of(plan));
            return result;
        });
}

}  // namespace afferent::python
