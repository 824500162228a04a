#include "afferent/view/messages.hpp"

#include <array>
#include <nlohmann/json.hpp>

namespace afferent {
namespace {

using Json = nlohmann::ordered_json;  // NaN becomes null

// A name from a scene may be anything.
std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json samples_of(const Portion& portion) {
    struct Column {
        const char* name;
        double ViewSample::*value;
    };
    static constexpr std::array<Column, 7> columns{{{"true_n", &ViewSample::true_n},
                                                    {"estimate_n", &ViewSample::estimate_n},
                                                    {"sigma_n", &ViewSample::sigma_n},
                                                    {"rate_hz", &ViewSample::rate_hz},
                                                    {"gain", &ViewSample::gain},
                                                    {"emg", &ViewSample::emg},
                                                    {"command", &ViewSample::command}}};
    Json json{{"time_s", Json::array()}};
    for (const ViewSample& sample : portion.samples) json["time_s"].push_back(seconds(sample.time));
    Json& doubts = json["doubt"] = Json::array();
    for (const ViewSample& sample : portion.samples) doubts.push_back(name(sample.doubt));
    for (const auto& [name, value] : columns) {
        Json& column = json[name] = Json::array();
        for (const ViewSample& sample : portion.samples) column.push_back(sample.*value);
    }
    return json;
}

Json link_points_of(const Portion& portion) {
    Json json{{"time_s", Json::array()}, {"bytes", Json::array()}};
    for (const LinkPoint& point : portion.link_points) {
        json["time_s"].push_back(seconds(point.time));
        json["bytes"].push_back(point.bytes);
    }
    return json;
}

Json motors_of(const LinkState& link) {
    Json motors = Json::array();
    for (const LinkState::Motor& motor : link.motors)
        motors.push_back(
            {{"name", motor.name}, {"position_deg", motor.position_deg}, {"current_a", motor.current_a}});
    return motors;
}

Json link_of(const LinkState& link) {
    return {{"time_s", seconds(link.time)},
            {"session", link.session},
            {"sessions", link.sessions},
            {"packets", link.packets},
            {"events", link.events},
            {"bytes", link.bytes},
            {"gaps", link.gaps},
            {"lost_events", link.lost_events},
            {"late_packets", link.late_packets},
            {"stale_packets", link.stale_packets},
            {"dropped_packets", link.dropped_packets},
            {"refused_frames", link.refused_frames},
            {"grip", link.grip},
            {"reason", link.reason},
            {"lateness_p50_ms", link.lateness_p50_ms},
            {"lateness_p99_ms", link.lateness_p99_ms},
            {"lateness_max_ms", link.lateness_max_ms},
            {"missed_deadlines", link.missed_deadlines},
            {"motors", motors_of(link)},
            {"temperature", link.temperature}};
}

Json json_of(const Portion& portion) {
    Json raster = Json::array();
    for (const RasterRun& run : portion.raster)
        raster.push_back({{"first_bin", run.first_bin}, {"counts", run.counts}});
    Json gaps = Json::array();
    for (const ViewGap& gap : portion.gaps)
        gaps.push_back({{"from_s", seconds(gap.begin)}, {"to_s", seconds(gap.end)}});
    Json notes = Json::array();
    for (const ViewNote& note : portion.notes)
        notes.push_back({{"time_s", seconds(note.time)}, {"text", note.text}});
    return {{"samples", samples_of(portion)},
            {"raster", std::move(raster)},
            {"gaps", std::move(gaps)},
            {"link_points", link_points_of(portion)},
            {"link", portion.link ? link_of(*portion.link) : Json()},
            {"notes", std::move(notes)}};
}

Json raster_of(const RasterLayout& layout) {
    Json patches = Json::array();
    for (const RasterLayout::Patch& patch : layout.patches())
        patches.push_back({{"name", patch.name},
                           {"afferents", patch.afferents},
                           {"first_row", patch.first_row},
                           {"rows", patch.rows}});
    return {{"bin_s", seconds(layout.bin())}, {"rows", layout.rows()}, {"patches", std::move(patches)}};
}

}  // namespace

std::string hello_message(const ViewTitle& title, const RasterLayout& layout, const Portion& last,
                          bool ended) {
    return text_of({{"kind", "hello"},
                    {"version", 1},
                    {"course", title.course},
                    {"command", title.command},
                    {"scene", title.scene},
                    {"limit_n", title.limit_n ? Json(*title.limit_n) : Json()},
                    {"raw_bytes_per_s", title.raw_bytes_per_s},
                    {"raster", raster_of(layout)},
                    {"portion", json_of(last)},
                    {"ended", ended}});
}

std::string update_message(const Portion& portion, std::uint64_t unseen) {
    return text_of({{"kind", "update"}, {"portion", json_of(portion)}, {"unseen", unseen}});
}

std::string dropped_message(std::uint64_t messages) {
    return text_of({{"kind", "dropped"}, {"messages", messages}});
}

std::string end_message() { return text_of({{"kind", "end"}}); }

}  // namespace afferent
