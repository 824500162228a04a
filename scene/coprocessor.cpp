#include "afferent/scene/coprocessor.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <thread>
#include <utility>

#include "afferent/neurons/models.hpp"
#include "afferent/scene/dense_shard.hpp"
#include "afferent/scene/form.hpp"
#include "afferent/scene/sparse_shard.hpp"

namespace afferent {
namespace {

// A window of fewer neurons than this is over before another thread has woken up.
constexpr std::uint32_t neurons_per_thread = 4096;
// Several shards for a thread, so that a busy patch is shared out.
constexpr std::uint32_t shards_per_thread = 4;

std::string about(const Patch& patch) {
    const NeuronParameters& neuron = patch.neuron;
    std::ostringstream text;
    text << "patch \"" << patch.name << "\": tau_m_ms " << neuron.tau_m_ms << ", tau_g_ms " << neuron.tau_g_ms
         << ", v_r_mv " << neuron.v_r_mv << ", v_th_mv " << neuron.v_th_mv << ", e_k_mv " << neuron.e_k_mv
         << ", delta_g " << neuron.delta_g << ", refractory_ms " << neuron.refractory_ms << ", gain "
         << patch.gain() << ", bias_mv " << patch.bias_mv();
    return text.str();
}

std::unique_ptr<Shard> make_shard(const Scene& scene, const Patch& patch, Address offset,
                                  std::uint32_t count) {
    const Address reads = scene.patches()[patch.reads].first + offset;
    const Address first = patch.first + offset;
    const Form form = form_of(scene, patch);
    const SpikeLimit limit{.spikes = scene.description().runtime().spikes_per_window(),
                           .window = form.scan_interval};
    return std::visit(
        [&](const auto& encoder, const auto& neuron) -> std::unique_ptr<Shard> {
            using Parameters = std::decay_t<decltype(encoder)>;
            using E =
                std::conditional_t<std::is_same_v<Parameters, Sustained::Parameters>, Sustained, Transient>;
            using N = std::decay_t<decltype(neuron)>;
            if (form.dense)
                return std::make_unique<DenseShard<E>>(E(encoder), patch.neuron, form.scan_interval, reads,
                                                       first, count, limit, about(patch));
            return std::make_unique<SparseShard<E, N>>(E(encoder), neuron, reads, first, count, limit,
                                                       about(patch));
        },
        patch.encoder, smallest_model(patch.neuron));
}

std::uint32_t shard_size(const Scene& scene) {
    const std::size_t threads = threads_for(scene);
    if (threads == 1) return scene.addresses();
    return std::max<std::uint32_t>(
        1024, scene.addresses() / static_cast<std::uint32_t>(threads * shards_per_thread));
}

}  // namespace

std::size_t threads_for(const Scene& scene) {
    if (const auto asked = scene.description().runtime().threads(); asked > 0) return asked;
    const std::size_t processors = std::max(1U, std::thread::hardware_concurrency());
    return std::clamp<std::size_t>(scene.addresses() / neurons_per_thread, 1, processors);
}

Coprocessor::Coprocessor(const Scene& scene) : workers_(threads_for(scene)) {
    const std::uint32_t size = shard_size(scene);
    elements_end_ = 0;
    for (std::size_t i = 0; i < scene.patches().size(); ++i) {
        const Patch& patch = scene.patches()[i];
        if (patch.owns_elements(i)) elements_end_ = patch.first + patch.elements;
        for (Address offset = 0; offset < patch.elements; offset += size) {
            const std::uint32_t count = std::min(size, patch.elements - offset);
            parts_.push_back({make_shard(scene, patch, offset, count), {}});
            parts_.back().events.reserve(std::max<std::size_t>(256, 2 * count));
        }
    }
    merge_ = EventMerge(parts_.size());
    // Two scans for each patch between two calls are usual; more make room once.
    scans_.reserve(4 * scene.patches().size());
    forces_n_.reserve(4 * scene.elements());
    events_.reserve(std::max<std::size_t>(1024, 2 * scene.addresses()));
}

Coprocessor::~Coprocessor() = default;
Coprocessor::Coprocessor(Coprocessor&&) noexcept = default;
Coprocessor& Coprocessor::operator=(Coprocessor&&) noexcept = default;

void Coprocessor::push(const Scan& scan) {
    const std::size_t room = scan.first < elements_end_ ? elements_end_ - scan.first : 0;
    const std::size_t count = std::min(scan.forces_n.size(), room);
    refused_samples_ += scan.forces_n.size() - count;
    if (scan.time < now_) ++late_scans_;
    const TimePoint time = std::max({scan.time, now_, scans_.empty() ? now_ : scans_.back().time});
    for (std::size_t i = 0; i < count;) {
        // A sample that is no force leaves the one before it standing: the scan is cut there.
        std::size_t end = i;
        while (end < count && std::isfinite(scan.forces_n[end])) ++end;
        if (end > i) {
            // Spans are made in advance(), when the forces no longer move.
            scans_.push_back({time, scan.first + static_cast<Address>(i), scan.forces_n.subspan(i, end - i)});
            forces_n_.insert(forces_n_.end(), scan.forces_n.begin() + static_cast<std::ptrdiff_t>(i),
                             scan.forces_n.begin() + static_cast<std::ptrdiff_t>(end));
        }
        if (end < count) ++refused_samples_;
        i = end + 1;
    }
}

std::span<const Event> Coprocessor::advance(TimePoint until) {
    std::size_t begin = 0;
    std::size_t due = 0;
    for (Scan& scan : scans_) {
        scan.forces_n = std::span(forces_n_).subspan(begin, scan.forces_n.size());
        begin += scan.forces_n.size();
        if (scan.time <= until) ++due;
    }
    const std::span<const Scan> scans(scans_.data(), due);
    const auto advance_part = [&](std::size_t i) {
        parts_[i].events.clear();
        parts_[i].shard->advance(until, scans, parts_[i].events);
    };
    workers_.run(parts_.size(),
                 std::ref(advance_part));  // a reference fits into std::function without memory
    std::size_t used = 0;
    for (const Scan& scan : scans) used += scan.forces_n.size();
    scans_.erase(scans_.begin(), scans_.begin() + static_cast<std::ptrdiff_t>(due));
    forces_n_.erase(forces_n_.begin(), forces_n_.begin() + static_cast<std::ptrdiff_t>(used));
    now_ = std::max(now_, until);
    merge_events();
    return events_;
}

// Each part is sorted. Patches may be given in any order of time, so the parts interleave.
void Coprocessor::merge_events() {
    merge_([this](std::size_t i) { return std::span<const Event>(parts_[i].events); }, events_);
}

std::size_t Coprocessor::bytes() const noexcept {
    std::size_t sum = 0;
    for (const Part& part : parts_) sum += part.shard->bytes();
    return sum;
}

void Coprocessor::reset() {
    for (Part& part : parts_) part.shard->reset();
    scans_.clear();
    forces_n_.clear();
    now_ = scene_start;
}

}  // namespace afferent
