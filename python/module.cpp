// The module afferent._afferent: what the package afferent is written over.
#include "afferent/python/bindings.hpp"
#include "afferent/runtime/spike_storm.hpp"
#include "afferent/scene/scene_error.hpp"

namespace afferent::python {

py::dtype row_dtype(std::initializer_list<Column> columns, std::size_t row_bytes) {
    py::list names;
    py::list formats;
    py::list offsets;
    for (const Column& column : columns) {
        names.append(column.name);
        formats.append(column.format);
        offsets.append(column.offset);
    }
    return {names, formats, offsets, static_cast<py::ssize_t>(row_bytes)};
}

py::array rows_in_place(const py::dtype& dtype, const void* first, std::size_t rows, std::size_t row_bytes,
                        const py::handle& owner) {
    py::array view(dtype, {rows}, {row_bytes}, first, owner);
    view.attr("flags").attr("writeable") = false;
    return view;
}

const py::dtype& event_dtype() {
    static_assert(sizeof(TimePoint) == sizeof(std::int64_t));
    // Kept until the process ends: an interpreter that has gone must not be asked to free it.
    static const auto* dtype = new py::dtype(row_dtype(
        {{"time", "i8", offsetof(Event, time)}, {"address", "u4", offsetof(Event, address)}}, sizeof(Event)));
    return *dtype;
}

EventArray::EventArray(const py::array& events) : array_(events) {
    const bool fits = events.dtype().is(event_dtype()) || events.dtype().equal(event_dtype());
    const bool in_place =
        fits && events.ndim() == 1 &&
        (events.size() == 0 || events.strides(0) == static_cast<py::ssize_t>(sizeof(Event)));
    if (!in_place)
        array_ =
            py::module_::import("numpy").attr("ascontiguousarray")(events.attr("ravel")(), event_dtype());
    events_ = {static_cast<const Event*>(array_.data()), static_cast<std::size_t>(array_.size())};
}

void require_within(std::span<const Event> events, TimePoint begin, TimePoint end, std::uint32_t addresses) {
    for (std::size_t i = 0; i < events.size(); ++i) {
        const Event& event = events[i];
        if (event.address >= addresses)
            throw py::value_error("address " + std::to_string(event.address) + ": the scene has " +
                                  std::to_string(addresses) + " afferents");
        if (event.time < begin || event.time >= end || (i > 0 && event < events[i - 1]))
            throw py::value_error("events must lie within the span, sorted by time and address; that at " +
                                  std::to_string(ns(event.time)) + " ns does not");
    }
}

namespace {

struct AfferentRow {
    std::uint32_t address;
    std::uint32_t patch;
    std::uint32_t element;
    std::uint32_t elements;
    double x_mm;
    double y_mm;
};

}  // namespace

void add_population(py::dict& result, const Population& population) {
    auto rows = std::make_unique<std::vector<AfferentRow>>();
    py::list patches;
    std::uint32_t address = 0;
    for (std::uint32_t i = 0; i < population.patches.size(); ++i) {
        const Population::Patch& patch = population.patches[i];
        patches.append(py::make_tuple(patch.name, address, patch.afferents, patch.kind));
        for (std::uint32_t k = 0; k < patch.afferents; ++k, ++address) {
            const Population::Afferent known = address < population.afferents.size()
                                                   ? population.afferents[address]
                                                   : Population::Afferent{.element = 0, .elements = 0};
            const Position place = known.place.value_or(Position{std::nan(""), std::nan("")});
            rows->push_back({address, i, known.element, known.elements, place.x_mm, place.y_mm});
        }
    }
    const py::dtype dtype = row_dtype({{"address", "u4", offsetof(AfferentRow, address)},
                                       {"patch", "u4", offsetof(AfferentRow, patch)},
                                       {"element", "u4", offsetof(AfferentRow, element)},
                                       {"elements", "u4", offsetof(AfferentRow, elements)},
                                       {"x_mm", "f8", offsetof(AfferentRow, x_mm)},
                                       {"y_mm", "f8", offsetof(AfferentRow, y_mm)}},
                                      sizeof(AfferentRow));
    auto& placed = *rows;
    result["patches"] = patches;
    result["afferents"] = rows_in_place(dtype, placed, owner_of(std::move(rows)));
}

namespace {

template <class... Arguments>
void raise(const char* type_name, const Arguments&... arguments) {
    const py::object type = py::module_::import("afferent.errors").attr(type_name);
    PyErr_SetObject(type.ptr(), type(arguments...).ptr());
}

}  // namespace

void bind_errors() {
    py::register_exception_translator([](std::exception_ptr pointer) {
        try {
            std::rethrow_exception(pointer);
        } catch (const SceneError& error) {
            raise("SceneError", error.messages());
        } catch (const SpikeStormError& error) {
            raise("SpikeStormError", error.what(), error.address(), ns(error.time()));
        } catch (const OutsideError& error) {
            const bool wrong_content = error.kind() == Error::Kind::malformed ||
                                       error.kind() == Error::Kind::checksum ||
                                       error.kind() == Error::Kind::out_of_order;
            raise(wrong_content ? "DataError" : "OutsideError", error.what());
        }
    });
}

void Watch::at(double fraction) {
    const auto now = Clock::now();
    if (now < next_) return;
    next_ = now + period;
    const py::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!progress_.is_none()) progress_(fraction);
}

void Watch::done() const {
    if (!progress_.is_none()) progress_(1.0);
}

}  // namespace afferent::python

PYBIND11_MODULE(_afferent, module) {
    using namespace afferent::python;
    module.doc() = "The library behind the package afferent.";
    module.attr("version") = AFFERENT_VERSION;
    bind_errors();
    module.attr("event_dtype") = event_dtype();
    bind_scene(module);
    bind_run(module);
    bind_embedding(module);
    bind_neuron(module);
    bind_files(module);
    bind_tables(module);
}
