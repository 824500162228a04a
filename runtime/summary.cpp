#include "afferent/runtime/summary.hpp"

namespace afferent {

Summary::Summary() = default;
Summary::Summary(double value) : value_(value) {}
Summary::Summary(std::string value) : value_(std::move(value)) {}
Summary::Summary(const char* value) : value_(std::string(value)) {}
Summary::Summary(std::initializer_list<Entry> entries) : value_(Entries(entries)) {}
Summary::Summary(List list) : value_(std::move(list)) {}
Summary::Summary(const Summary&) = default;
Summary::Summary(Summary&&) noexcept = default;
Summary& Summary::operator=(const Summary&) = default;
Summary& Summary::operator=(Summary&&) noexcept = default;
Summary::~Summary() = default;

Summary& Summary::operator[](std::string_view key) {
    if (std::holds_alternative<std::monostate>(value_)) value_ = Entries();
    auto& entries = std::get<Entries>(value_);
    for (Entry& entry : entries)
        if (entry.key == key) return entry.value;
    return entries.emplace_back(Entry{std::string(key), {}}).value;
}

const Summary* Summary::find(std::string_view key) const noexcept {
    for (const Entry& entry : entries())
        if (entry.key == key) return &entry.value;
    return nullptr;
}

void Summary::push_back(Summary value) {
    if (std::holds_alternative<std::monostate>(value_)) value_ = List();
    std::get<List>(value_).push_back(std::move(value));
}

const Summary::Entries& Summary::entries() const noexcept {
    static const Entries none;
    const auto* entries = std::get_if<Entries>(&value_);
    return entries ? *entries : none;
}

const Summary::List& Summary::list() const noexcept {
    static const List none;
    const auto* list = std::get_if<List>(&value_);
    return list ? *list : none;
}

std::optional<double> Summary::number() const noexcept {
    if (const auto* value = std::get_if<double>(&value_)) return *value;
    if (const auto* value = std::get_if<std::int64_t>(&value_)) return static_cast<double>(*value);
    if (const auto* value = std::get_if<std::uint64_t>(&value_)) return static_cast<double>(*value);
    return std::nullopt;
}

}  // namespace afferent
