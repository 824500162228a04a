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
            patch.settings.push_back({i, std::move(cell), 0, 0, 0});
            SchemeSetting& setting = patch.settings.back();
            setting.delay_s = seconds(batches ? setting.cell.deadline : Duration(0));
        }
    Workers(std::max(1U, std::thread::hardware_concurrency())).run(patch.settings.size(), [&](std::size_t k) {
        SchemeSetting& setting = patch.settings[k];
        const Touch& touch = patch.touches[setting.tuned];
        setting.bytes_per_s = bytes_per_s(touch.activity, setting.cell);
        if (setting.cell.scheme != "delta_varint")
            setting.rms_n = score(follow(touch, setting.cell), Touch::step).rms_n;
    });
    // The same samples.
    for (SchemeSetting& setting : patch.settings)
        if (setting.cell.scheme == "delta_varint")
            for (const SchemeSetting& other : patch.settings)
                if (other.cell.scheme == "raw12" && other.cell.deadline == setting.cell.deadline &&
                    other.cell.every_scan == setting.cell.every_scan)
                    setting.rms_n = other.rms_n;
    return patch;
}

// `touched` of so many patches, each at another time of its touch, and the others at rest.
LinkActivity crowd(const LinkActivity& touch, const LinkActivity& rest, std::size_t patches,
                   std::size_t touched) {
    LinkActivity all = touch;
    const std::size_t scans = touch.scans();
    all.elements = static_cast<std::uint32_t>(patches * touch.elements);
    all.addresses = static_cast<std::uint32_t>(patches * touch.addresses);
    all.events.clear();
    all.counts.assign(scans * all.elements, 0);
    for (std::size_t i = 0; i < patches; ++i) {
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
    static const std::vector<std::string> names{"events", "raw12", "delta_varint", "send_on_delta"};
    return names;
}

// The cheapest of a scheme's settings for one patch that is exact and fast enough; null where there is none.
const SchemeSetting* cheapest(const Patch& patch, const std::string& scheme, Duration allowed,
                              double error_n) {
    const SchemeSetting* best = nullptr;
    for (const SchemeSetting& setting : patch.settings)
        if (setting.cell.scheme == scheme && setting.rms_n <= error_n &&
            setting.delay_s <= seconds(allowed - delivery) + 1e-9 &&
            (!best || setting.bytes_per_s < best->bytes_per_s))
            best = &setting;
    return best;
}

}  // namespace

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
                    if (const SchemeSetting* setting = cheapest(patch, scheme, span + delivery, error_n))
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
                for (const std::string& scheme : schemes())
                    if (const SchemeSetting* setting = cheapest(patch, scheme, span + delivery, error_n))
                        cell.costs.push_back(
                            {scheme,
                             bytes[static_cast<std::size_t>(std::find(wanted.begin(), wanted.end(), setting) -
                                                            wanted.begin())]});
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
    out << "  " << std::left << std::setw(26) << "none" << std::right << std::setw(10)
        << std::count_if(map.begin(), map.end(), [](const MapCell& cell) { return !cell.cheapest(); })
        << '\n';
}

}  // namespace afferent
