#include "afferent/apps/summary.hpp"

#include <algorithm>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "afferent/apps/failure.hpp"

namespace afferent {
namespace {

using Json = nlohmann::ordered_json;

// Limits recursion, so that a peer's message cannot exhaust the stack.
constexpr int deepest = 16;

Json to_json(const Summary& summary) {
    return std::visit(
        []<class T>(const T& value) -> Json {
            if constexpr (std::is_same_v<T, std::monostate>) {
                return nullptr;
            } else if constexpr (std::is_same_v<T, Summary::List>) {
                Json list = Json::array();
                for (const Summary& each : value) list.push_back(to_json(each));
                return list;
            } else if constexpr (std::is_same_v<T, Summary::Entries>) {
                Json object = Json::object();
                for (const auto& [key, each] : value) object[key] = to_json(each);
                return object;
            } else {
                return value;
            }
        },
        summary.value());
}

Summary from_json(const Json& json, int depth) {
    switch (json.type()) {
        case Json::value_t::boolean:
            return json.get<bool>();
        case Json::value_t::number_integer:
            return json.get<std::int64_t>();
        case Json::value_t::number_unsigned:
            return json.get<std::uint64_t>();
        case Json::value_t::number_float:
            return json.get<double>();
        case Json::value_t::string:
            return json.get<std::string>();
        default:
            break;
    }
    if (!json.is_structured() || depth == deepest) return {};
    Summary summary =
        json.is_array() ? Summary(Summary::List{}) : Summary(std::initializer_list<Summary::Entry>{});
    for (const auto& [key, value] : json.items()) {
        if (json.is_array())
            summary.push_back(from_json(value, depth + 1));
        else
            summary[key] = from_json(value, depth + 1);
    }
    return summary;
}

}  // namespace

std::string json(const Summary& summary, int indent) {
    return to_json(summary).dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::optional<Summary> parse_summary(std::string_view text) {
    const Json json = Json::parse(text, nullptr, false);
    if (json.is_discarded()) return std::nullopt;
    return from_json(json, 0);
}

namespace {

// Each text of a list on a line of its own.
bool put_texts(std::ostream& out, const Summary::List& list, std::size_t indent) {
    if (list.empty() ||
        !std::ranges::all_of(list, [](const Summary& each) { return each.text() != nullptr; }))
        return false;
    for (std::size_t i = 0; i < list.size(); ++i)
        out << (i == 0 ? "" : std::string(indent, ' ')) << *list[i].text() << '\n';
    return true;
}

// Entries of entries are indented below their name.
void put_indented(std::ostream& out, const Summary& summary, std::size_t indent) {
    std::size_t width = 26;
    for (const auto& [key, value] : summary.entries()) width = std::max(width, key.size());
    for (const auto& [key, value] : summary.entries()) {
        std::string name = key;
        std::replace(name.begin(), name.end(), '_', ' ');
        out << std::string(indent, ' ') << std::left << std::setw(static_cast<int>(width + 2)) << name;
        if (!value.entries().empty()) {
            out << '\n';
            put_indented(out, value, indent + 2);
            continue;
        }
        if (put_texts(out, value.list(), indent + width + 2)) continue;
        if (const std::string* text = value.text())
            out << *text;
        else if (const double* number = std::get_if<double>(&value.value()))
            out << std::setprecision(6) << *number;
        else if (std::holds_alternative<std::monostate>(value.value()))
            out << "not known";
        else
            out << json(value);
        out << '\n';
    }
}

}  // namespace

std::string text(const Summary& summary, bool json) {
    if (json) return afferent::json(summary, 2) + '\n';
    std::ostringstream out;
    put_indented(out, summary, 2);
    return out.str();
}

void print(const Summary& summary) { print(summary, false); }

void print(const Summary& summary, bool json) { std::cout << text(summary, json); }

void write(const Summary& summary, const std::filesystem::path& file) {
    std::ofstream out(file);
    out << json(summary, 2) << '\n';
    out.close();
    if (!out) throw Failure(file.string() + ": cannot be written");
}

void append(Summary& summary, const Summary& more) {
    for (const auto& [key, value] : more.entries()) summary[key] = value;
}

}  // namespace afferent
