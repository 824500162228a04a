// Files of events.
#include "afferent/io/files/event_files.hpp"
#include "afferent/nodes/event_file.hpp"
#include "afferent/python/bindings.hpp"

namespace afferent::python {
namespace {

// With what is known of the afferents, and what is incomplete.
py::dict read_events_of(const std::filesystem::path& file) {
    std::unique_ptr<EventFile> read;
    {
        const py::gil_scoped_release unlocked;
        read = std::make_unique<EventFile>(value_or_throw(read_event_file(file)));
    }
    py::dict result;
    add_population(result, read->set.population);
    result["resolution_ns"] = read->set.resolution.count();
    result["remarks"] = read->remarks;
    std::vector<Event>& events = read->set.events;
    result["events"] = rows_in_place(event_dtype(), events, owner_of(std::move(read)));
    return result;
}

py::bytes events_as(const std::filesystem::path& file, const py::array& events) {
    const EventArray array(events);
    std::vector<std::byte> bytes;
    {
        const py::gil_scoped_release unlocked;
        if (!std::is_sorted(array.span().begin(), array.span().end()))
            throw py::value_error("events must be sorted by time and address");
        bytes = value_or_throw(write_events(array.span(), value_or_throw(format_of(file))));
    }
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

void bind_files(py::module_& module) {
    module.def("read_events", read_events_of, py::arg("file"));
    // The content of a file of that name.
    module.def("events_as", events_as, py::arg("file"), py::arg("events"));
}

}  // namespace afferent::python
