// What is reported of a run, for people and for programs: a value that keeps its entries in the order
// in which they were added.
#pragma once

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace afferent {

class Summary {
  public:
    struct Entry;
    using Entries = std::vector<Entry>;
    using List = std::vector<Summary>;
    using Value =
        std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string, List, Entries>;

    // Not known: null in JSON.
    Summary();
    template <std::integral T>
    Summary(T value);
    Summary(double value);
    Summary(std::string value);
    Summary(const char* value);
    Summary(std::initializer_list<Entry> entries);
    Summary(List list);
    // Defined where Entry is complete.
    Summary(const Summary&);
    Summary(Summary&&) noexcept;
    Summary& operator=(const Summary&);
    Summary& operator=(Summary&&) noexcept;
    ~Summary();

    // The entry of that key; added at the end if there is none. Turns an unknown value into entries.
    Summary& operator[](std::string_view key);
    // Null where there is none.
    const Summary* find(std::string_view key) const noexcept;
    // Turns an unknown value into a list.
    void push_back(Summary value);

    const Value& value() const noexcept { return value_; }
    // Empty where it has none.
    const Entries& entries() const noexcept;
    const List& list() const noexcept;
    // As a double, whichever number it is.
    std::optional<double> number() const noexcept;
    // Null if it is not text.
    const std::string* text() const noexcept { return std::get_if<std::string>(&value_); }

  private:
    Value value_;
};

struct Summary::Entry {
    std::string key;
    Summary value;
};

template <std::integral T>
Summary::Summary(T value) {
    if constexpr (std::is_same_v<T, bool>)
        value_ = value;
    else if constexpr (std::is_signed_v<T>)
        value_ = std::int64_t{value};
    else
        value_ = std::uint64_t{value};
}

// Null where there is none.
inline Summary or_null(std::optional<double> value) { return value ? Summary(*value) : Summary(); }

}  // namespace afferent
