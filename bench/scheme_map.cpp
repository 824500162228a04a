#include "bench/scheme_map.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <mutex>
#include <optional>
#include <thread>
#include <tuple>
#include <utility>

#include "afferent/runtime/parallel.hpp"
#include "bench/decoding_bench.hpp"
#include "bench/table_file.hpp"

namespace afferent {
namespace {

// A way to send, and what it does to the force of one patch.
struct SchemeSetting {
    std::size_t tuned;  // index into `Patch::touches`
    DecodingCell cell;
    double rms_n;
    double bytes_per_s;  // of one patch that is always touched
    double among_many;   // of several
    double delay_s;      // of the oldest scan of a packet
};

struct Patch {
    std::vector<Touch> touches;  // with neurons tuned to fire less and more
    LinkActivity rest;
    std::vector<SchemeSetting> settings;
};

// The grasp from just before its contact to just after its end, of a length that whole packets fill.
std::pair<TimePoint, Duration> contact_of(const GripForce& force_n, TimePoint end) {
    TimePoint first = end;
    TimePoint last = scene_start;
    for (TimePoint time = scene_start; time < end; time += Touch::step)
        if (force_n(time) > 0) {
            first = std::min(first, time);
            last = time;
        }
    const Duration whole = ((last - first + 500ms) / 100ms) * 100ms;
    return {first - 200ms, whole};
}

// A patch of so many elements, tuned to `tuned` times the rate of the scene's neurons.
Scene patch_scene(const Scene& grasp, std::uint32_t elements, double tuned) {
    Scene scene = grasp;
    if (elements == 1) {
        scene.patches.resize(1);
        scene.patches.front().elements = 1;
        scene.patches.front().share = {1};
        scene.patches.front().sensor.full_scale_n = 25;
    }
    for (scene::Patch& patch : scene.patches) patch.neuron.tuning.rate_hz *= tuned;
    return elements == 1 ? scene : scaled_scene(scene, elements);
}

// `touched` of so many patches, each at another time of its touch, and the others at rest.
LinkActivity crowd(const LinkActivity& touch, const LinkActivity& rest, std::size_t patches,
                   std::size_t touched) {
    LinkActivity all = touch;
    const std::size_t scans = touch.scans();
    all.elements = static_cast<std::uint32_t>(patches * touch.elements);
    all.addresses = static_cast<std::uint32_t>(patches * touch.addresses);
    all.neurons.clear();
    all.events.clear();
    all.counts.assign(scans * all.elements, 0);
    for (std::size_t i = 0; i < patches; ++i) {
        // A patch at rest is built like the others.
        all.neurons.insert(all.neurons.end(), touch.neurons.begin(), touch.neurons.end());
        const LinkActivity& own = i < touched ? touch : rest;
        const std::size_t ahead = (i < touched ? i * scans / touched : i * 7) % scans;
        for (std::size_t s = 0; s < scans; ++s) {
            const auto scan = own.scan((s + ahead) % scans);
            std::copy(
                scan.begin(), scan.end(),
                all.counts.begin() + static_cast<std::ptrdiff_t>(s * all.elements + i * touch.elements));
        }
        const Duration shift = static_cast<Duration::rep>(ahead) * touch.frame_interval;
        for (const Event& event : own.events)
            all.events.push_back(
                {scene_start + (event.time - scene_start + touch.duration - shift) % touch.duration,
                 static_cast<Address>(i * touch.addresses + event.address)});
    }
    std::sort(all.events.begin(), all.events.end());
    return all;
}

Patch make_patch(const Scene& grasp, std::uint32_t elements, bool quick) {
    const GripForce whole = grip_force_of(grasp);
    const auto [begin, duration] = contact_of(whole, grasp.end());
    const GripForce contact = [whole, from = begin - scene_start](TimePoint time) {
        return whole(time + from);
    };
    Patch patch;
    for (const double tuned : {1.0, 0.25, 0.5, 2.0}) {
        if (quick && tuned != 1) continue;
        std::vector<TouchedForce> forces{
            touched_force(patch_scene(grasp, elements, tuned), duration, contact)};
        patch.touches.emplace_back("", std::move(forces));
    }
    patch.rest =
        touched_force(patch_scene(grasp, elements, 1), duration, [](TimePoint) { return 0.0; }).activity;

    for (std::size_t i = 0; i < patch.touches.size(); ++i)
        for (DecodingCell& cell : decoding_cells(patch.touches[i], quick)) {
            const bool events = cell.tick.has_value();
            if (events ? cell.decoder != "filter" || cell.deadline == Duration(2ms)
                       : i > 0 || cell.decoder != "force_model")
                continue;
            const Duration interval = cell.every_scan * patch.rest.frame_interval;
            const bool batches = events || cell.deadline > interval;
            patch.settings.push_back({i, std::move(cell), 0, 0, 0, 0});
            SchemeSetting& setting = patch.settings.back();
            setting.delay_s = seconds(batches ? setting.cell.deadline : Duration(0));
        }
    constexpr std::size_t many = 30;
    std::vector<LinkActivity> together;
    for (const Touch& touch : patch.touches)
        together.push_back(crowd(touch.activity, patch.rest, many, many));
    Workers(std::max(1U, std::thread::hardware_concurrency())).run(patch.settings.size(), [&](std::size_t k) {
        SchemeSetting& setting = patch.settings[k];
        const Touch& touch = patch.touches[setting.tuned];
        setting.bytes_per_s = bytes_per_s(touch.activity, setting.cell);
        setting.among_many = bytes_per_s(together[setting.tuned], setting.cell);
        if (told_alike(setting.cell) == setting.cell)
            setting.rms_n = score(follow(touch, setting.cell), Touch::step).rms_n;
    });
    for (SchemeSetting& setting : patch.settings)
        for (const SchemeSetting& other : patch.settings)
            if (other.tuned == setting.tuned && other.cell == told_alike(setting.cell))
                setting.rms_n = other.rms_n;
    return patch;
}

// What one crowd's packets carry, by setting.
std::vector<double> crowd_bytes(const Patch& patch, const std::vector<const SchemeSetting*>& wanted,
                                std::size_t patches, std::size_t touched) {
    std::vector<double> bytes(wanted.size());
    for (std::size_t tuned = 0; tuned < patch.touches.size(); ++tuned) {
        std::optional<LinkActivity> all;
        for (std::size_t k = 0; k < wanted.size(); ++k) {
            if (wanted[k]->tuned != tuned) continue;
            if (!all) all = crowd(patch.touches[tuned].activity, patch.rest, patches, touched);
            bytes[k] = bytes_per_s(*all, wanted[k]->cell);
        }
    }
    return bytes;
}

const std::vector<std::string>& schemes() {
    static const std::vector<std::string> names{
        "events",        "predicted",         "raw12",    "delta_varint", "delta_coded",
        "send_on_delta", "linear_prediction", "dead_band"};
    return names;
}

// Up to two settings of a scheme, among those that are exact and fast enough: the cheapest one for a single
// patch, and the cheapest one for many patches, where frames hardly count. Empty if no setting is.
std::vector<const SchemeSetting*> cheapest(const Patch& patch, const std::string& scheme, Duration allowed,
                                           double error_n) {
    std::vector<const SchemeSetting*> best;
    for (const auto bytes : {&SchemeSetting::bytes_per_s, &SchemeSetting::among_many}) {
        const SchemeSetting* least = nullptr;
        for (const SchemeSetting& setting : patch.settings)
            if (setting.cell.scheme == scheme && setting.rms_n <= error_n &&
                setting.delay_s <= seconds(allowed - delivery) + 1e-9 &&
                (!least || setting.*bytes < least->*bytes))
                least = &setting;
        if (least) best.push_back(least);
    }
    return best;
}

}  // namespace

bool is_of_events(const std::string& scheme) { return scheme == "events" || scheme == "predicted"; }

std::vector<MapCell> map_schemes(const Scene& grasp, bool quick,
                                 const std::function<void(double)>& progress) {
    using Numbers = std::vector<double>;
    const std::vector<std::uint32_t> elements =
        quick ? std::vector<std::uint32_t>{10, 1000} : std::vector<std::uint32_t>{1, 10, 100, 1000, 10'000};
    const Numbers activities = quick ? Numbers{0.1, 1} : Numbers{0.01, 0.03, 0.1, 0.3, 1};
    const Numbers errors_n = quick ? Numbers{0.2} : Numbers{0.1, 0.2, 0.5};
    const std::vector<Duration> spans =
        quick ? std::vector<Duration>{5ms, 20ms} : std::vector<Duration>{5ms, 10ms, 20ms, 50ms};
    const Patch ten = make_patch(grasp, 10, quick);
    const std::optional<Patch> one = quick ? std::nullopt : std::optional(make_patch(grasp, 1, quick));

    std::vector<std::pair<std::uint32_t, double>> crowds;
    for (const std::uint32_t count : elements)
        for (const double activity : activities) crowds.emplace_back(count, activity);
    std::vector<std::vector<MapCell>> found(crowds.size());
    std::mutex reporting;
    std::size_t done = 0;
    Workers(std::max(1U, std::thread::hardware_concurrency())).run(crowds.size(), [&](std::size_t job) {
        const std::size_t c = crowds.size() - 1 - job;  // the largest first
        const auto [count, activity] = crowds[c];
        const Patch& patch = count == 1 ? *one : ten;
        const std::size_t patches = count == 1 ? 1 : count / 10;
        std::vector<const SchemeSetting*> wanted;
        for (const Duration span : spans)
            for (const double error_n : errors_n)
                for (const std::string& scheme : schemes())
                    for (const SchemeSetting* setting : cheapest(patch, scheme, span + delivery, error_n))
                        if (std::find(wanted.begin(), wanted.end(), setting) == wanted.end())
                            wanted.push_back(setting);
        // Where less than one patch would be touched in the mean, one patch is touched for that part of the
        // time.
        const double touched = activity * static_cast<double>(patches);
        const auto fewer = static_cast<std::size_t>(touched + 1e-9);
        const double more = std::max(0.0, touched - static_cast<double>(fewer));
        std::vector<double> bytes = crowd_bytes(patch, wanted, patches, fewer);
        if (more > 1e-6) {
            const std::vector<double> upper = crowd_bytes(patch, wanted, patches, fewer + 1);
            for (std::size_t k = 0; k < bytes.size(); ++k) bytes[k] += more * (upper[k] - bytes[k]);
        }
        for (const Duration span : spans)
            for (const double error_n : errors_n) {
                MapCell cell{count, activity, span + delivery, error_n, {}};
                for (const std::string& scheme : schemes()) {
                    std::optional<double> least;
                    for (const SchemeSetting* setting : cheapest(patch, scheme, span + delivery, error_n)) {
                        const auto k = std::find(wanted.begin(), wanted.end(), setting) - wanted.begin();
                        const double own = bytes[static_cast<std::size_t>(k)];
                        least = std::min(least.value_or(own), own);
                    }
                    if (least) cell.costs.push_back({scheme, *least});
                }
                std::sort(cell.costs.begin(), cell.costs.end(), [](const auto& a, const auto& b) {
                    return std::tie(a.bytes_per_s, a.scheme) < std::tie(b.bytes_per_s, b.scheme);
                });
                found[c].push_back(std::move(cell));
            }
        const std::lock_guard lock(reporting);
        progress(static_cast<double>(++done) / static_cast<double>(crowds.size()));
    });
    std::vector<MapCell> map;
    for (std::vector<MapCell>& cells : found)
        map.insert(map.end(), std::make_move_iterator(cells.begin()), std::make_move_iterator(cells.end()));
    return map;
}

void write_map(const std::vector<MapCell>& map, const std::filesystem::path& folder) {
    std::vector<std::string> columns{"elements", "activity", "allowed_delay_ms", "error_n", "cheapest"};
    for (const std::string& scheme : schemes()) columns.push_back(scheme + "_bytes_per_s");
    bench::TableFile file(folder / "map.csv", columns);
    for (const MapCell& cell : map) {
        std::vector<std::string> cells{std::to_string(cell.elements), bench::number(cell.activity),
                                       bench::number(Milliseconds(cell.allowed_delay).count()),
                                       bench::number(cell.error_n),
                                       cell.cheapest() ? cell.cheapest()->scheme : ""};
        for (const std::string& scheme : schemes()) {
            const auto cost = std::find_if(cell.costs.begin(), cell.costs.end(),
                                           [&](const auto& each) { return each.scheme == scheme; });
            cells.push_back(cost == cell.costs.end() ? "" : bench::number(std::round(cost->bytes_per_s)));
        }
        file.row(cells);
    }
    file.close();
}

void print_map(const std::vector<MapCell>& map, std::ostream& out) {
    out << "\nThe scheme with the fewest bytes at an allowed error, in so many of the " << map.size()
        << " cells of the map (map.csv)\n";
    for (const std::string& scheme : schemes())
        out << "  " << std::left << std::setw(26) << scheme << std::right << std::setw(10)
            << std::count_if(
                   map.begin(), map.end(),
                   [&](const MapCell& cell) { return cell.cheapest() && cell.cheapest()->scheme == scheme; })
            << '\n';
    const auto events = [](const MapCell& cell) {
        return std::any_of(cell.costs.begin(), cell.costs.end(),
                           [](const MapCell::Cost& cost) { return is_of_events(cost.scheme); });
    };
    out << "  " << std::left << std::setw(26) << "none" << std::right << std::setw(10)
        << std::count_if(map.begin(), map.end(), [](const MapCell& cell) { return !cell.cheapest(); })
        << "\nEvents, predicted or not, have the fewest bytes in "
        << std::count_if(
               map.begin(), map.end(),
               [](const MapCell& cell) { return cell.cheapest() && is_of_events(cell.cheapest()->scheme); })
        << " cells, and in "
        << map.size() - static_cast<std::size_t>(std::count_if(map.begin(), map.end(), events))
        << " no setting of theirs is exact enough.\n";
}

}  // namespace afferent
