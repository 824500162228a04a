// What the bindings have in common: arrays over the rows of the library, its errors, and the interpreter's
// lock.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "afferent/runtime/event.hpp"
#include "afferent/runtime/population.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent::python {

namespace py = pybind11;

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Times = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

// ---- structured arrays ----

struct Column {
    const char* name;
    const char* format;  // as NumPy has it: "i8"
    std::size_t offset;
};

// The type of rows of that size.
py::dtype row_dtype(std::initializer_list<Column> columns, std::size_t row_bytes);
// time (int64, ns) and address (uint32).
const py::dtype& event_dtype();

// A view of rows, which live as long as their owner. Read-only: other views have the same memory.
py::array rows_in_place(const py::dtype& dtype, const void* first, std::size_t rows, std::size_t row_bytes,
                        const py::handle& owner);
template <class Row>
py::array rows_in_place(const py::dtype& dtype, const std::vector<Row>& rows, const py::handle& owner) {
    return rows_in_place(dtype, rows.data(), rows.size(), sizeof(Row), owner);
}
// Owns the value, for arrays over its members.
template <class T>
py::capsule owner_of(std::unique_ptr<T> value) {
    return {value.release(), [](void* pointer) { delete static_cast<T*>(pointer); }};
}

// Events as the library has them: in place where the array has the layout of event_dtype(), else converted.
class EventArray {
  public:
    explicit EventArray(const py::array& events);
    std::span<const Event> span() const noexcept { return events_; }

  private:
    py::array array_;
    std::span<const Event> events_;
};
// Throws ValueError where they are not sorted, not within [begin, end), or not of these addresses.
void require_within(std::span<const Event> events, TimePoint begin, TimePoint end, std::uint32_t addresses);

inline TimePoint time_point(std::int64_t ns) { return scene_start + Duration(ns); }
inline std::int64_t ns(TimePoint time) { return (time - scene_start).count(); }

// What each address stands for: the keys "patches" (name, first, afferents, kind) and "afferents", an array.
void add_population(py::dict& result, const Population& population);

// ---- errors ----

// What came from outside was refused.
class OutsideError : public std::runtime_error {
  public:
    explicit OutsideError(const Error& error) : std::runtime_error(error.text), kind_(error.kind) {}
    Error::Kind kind() const noexcept { return kind_; }

  private:
    Error::Kind kind_;
};

template <class T>
T value_or_throw(Result<T>&& result) {
    if (!result) throw OutsideError(result.error());
    if constexpr (!std::is_void_v<T>) return std::move(result).value();
}

void bind_errors();

// ---- the interpreter's lock ----

// An object that computes while other threads of Python run; they may not use it meanwhile.
class Exclusive {
  public:
    // Both with the lock held.
    void require_free() const {
        if (busy_) throw std::runtime_error("in use by another thread");
    }
    // Calls compute() without the lock.
    template <class F>
    decltype(auto) without_lock(F&& compute) {
        require_free();
        const Busy busy(busy_);
        const py::gil_scoped_release unlocked;
        return compute();
    }

  private:
    struct Busy {
        explicit Busy(bool& busy) : flag(busy) { flag = true; }
        ~Busy() { flag = false; }
        Busy(const Busy&) = delete;
        Busy& operator=(const Busy&) = delete;
        bool& flag;
    };
    bool busy_ = false;
};

// Lets a long computation without the lock be interrupted, and tell its progress: a call to at() takes the
// lock twenty times a second, and throws what Python's signal handlers or the callback have raised.
class Watch {
  public:
    // None: nobody is told.
    explicit Watch(py::object progress) : progress_(std::move(progress)) {}
    // The fraction that is done.
    void at(double fraction);
    // To be called with the lock held.
    void done() const;

  private:
    using Clock = std::chrono::steady_clock;
    static constexpr std::chrono::milliseconds period{50};

    py::object progress_;
    Clock::time_point next_ = Clock::now() + period;
};

// ---- the parts of the module ----

void bind_scene(py::module_& module);
void bind_run(py::module_& module);
void bind_embedding(py::module_& module);
void bind_neuron(py::module_& module);
void bind_files(py::module_& module);
void bind_tables(py::module_& module);

}  // namespace afferent::python
