#include "bench/scale_export.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/scale_bench.hpp"
#include "bench/table_file.hpp"
#include "bench/thread_time.hpp"

namespace afferent::bench {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr const char* float64 = "<f8";
constexpr const char* int64 = "<i8";
constexpr const char* uint32 = "<u4";

// NumPy's format, version 1.0: magic, length of the header, a Python dictionary padded to 64 bytes, numbers.
template <class T>
void write_npy(const std::filesystem::path& path, const char* type, const std::string& shape,
               std::span<const T> values) {
    std::string header =
        std::string("{'descr': '") + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
    constexpr std::size_t before = 10;
    header.append(63 - (before + header.size()) % 64, ' ');
    header += '\n';
    std::ofstream file(path, std::ios::binary);
    const auto length = static_cast<std::uint16_t>(header.size());
    const std::array<char, 2> length_bytes{static_cast<char>(length & 0xFF), static_cast<char>(length >> 8)};
    file << "\x93NUMPY" << '\x01' << '\x00';
    file.write(length_bytes.data(), length_bytes.size());
    file << header;
    file.write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(values.size_bytes()));
    file.close();
    if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

struct Timed {
    std::vector<Event> events;
    double median_s;
};

Timed timed(const ScaleRun& run, const ScaleTouch& touch, std::uint64_t frames) {
    Timed result;
    std::array<double, 5> took_s{};
    for (double& each : took_s) {
        result.events.clear();
        RunningScale running(run, touch);
        const double begin_s = thread_seconds();
        for (std::uint64_t frame = 0; frame < frames; ++frame) {
            const std::span<const Event> events = running.frame();
            result.events.insert(result.events.end(), events.begin(), events.end());
        }
        each = thread_seconds() - begin_s;
    }
    std::ranges::sort(took_s);
    result.median_s = took_s[took_s.size() / 2];
    return result;
}

}  // namespace

ScaleExport export_population(std::uint32_t elements, Duration duration,
                              const std::filesystem::path& folder) {
    const auto frames = static_cast<std::uint64_t>(duration / scale_frame);
    const ScalePopulation population{.elements = elements};
    const ScaleTouch touch(population);
    Timed sparse = timed({population, scene::Form::sparse}, touch, frames);
    Timed dense = timed({population, scene::Form::dense}, touch, frames);
    const TimePoint end = scene_start + static_cast<Duration::rep>(frames) * scale_frame;
    require_same_events(sparse.events, dense.events, end, "sparse and dense");

    const PatchPlan patch = make_plan(scale_scene({population})).patches.front();
    const auto common = std::get<LifParameters>(patch.neuron);
    const Sustained::Parameters encoder = scale_encoder(population.adapts);
    std::vector<double> v_th_mv;
    std::vector<double> v_mv;
    for (std::uint32_t i = 0; i < elements; ++i) {
        const auto own = std::get<LifParameters>(patch.neuron_of(i));
        v_th_mv.push_back(own.v_th_mv);
        v_mv.push_back(own.v_r_mv + patch.phases(i) * (own.v_th_mv - own.v_r_mv));
    }
    std::vector<double> drives_mv;
    drives_mv.reserve(frames * elements);
    for (std::uint64_t frame = 0; frame < frames; ++frame)
        for (std::uint32_t i = 0; i < elements; ++i)
            drives_mv.push_back(encoder.gain_mv_per_n * touch.force_n(frame, i) + encoder.bias_mv);
    std::vector<std::int64_t> times_ns;
    std::vector<std::uint32_t> addresses;
    for (const Event& event : dense.events) {
        times_ns.push_back((event.time - scene_start).count());
        addresses.push_back(event.address);
    }

    TableFile parameters(folder / "parameters.csv",
                         {"elements", "frames", "frame_ms", "tau_m_ms", "tau_g_ms", "v_r_mv", "e_k_mv",
                          "delta_g", "events", "dense_s", "sparse_s"});
    parameters.row({std::to_string(elements), std::to_string(frames),
                    number(Milliseconds(scale_frame).count()), number(common.tau_m_ms),
                    number(common.tau_g_ms), number(common.v_r_mv), number(common.e_k_mv),
                    number(common.delta_g), std::to_string(times_ns.size()), number(dense.median_s),
                    number(sparse.median_s)});
    parameters.close();
    const std::string each = std::to_string(elements) + ",";
    const std::string spikes = std::to_string(times_ns.size()) + ",";
    write_npy<double>(folder / "v_th_mv.npy", float64, each, v_th_mv);
    write_npy<double>(folder / "v_mv.npy", float64, each, v_mv);
    write_npy<double>(folder / "drives_mv.npy", float64,
                      std::to_string(frames) + ", " + std::to_string(elements), drives_mv);
    write_npy<std::int64_t>(folder / "spike_time_ns.npy", int64, spikes, times_ns);
    write_npy<std::uint32_t>(folder / "spike_address.npy", uint32, spikes, addresses);
    return {times_ns.size(), dense.median_s, sparse.median_s};
}

}  // namespace afferent::bench
