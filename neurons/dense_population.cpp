#include "afferent/neurons/dense_population.hpp"

#include <algorithm>
#include <utility>

#include "afferent/neurons/dense_sweeper.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// The only model whose solution the polynomials are.
const LifParameters& lif(const NeuronModel& model) {
    if (const auto* parameters = std::get_if<LifParameters>(&model)) return *parameters;
    throw ParameterError("neuron", "lif for the dense form, which evaluates its exact solution", name(model));
}

// What the neurons of a part have in common.
bool alike(const LifParameters& one, const LifParameters& other, Duration scan_interval) {
    return one.tau_m_ms == other.tau_m_ms && one.tau_g_ms == other.tau_g_ms && one.v_r_mv == other.v_r_mv &&
           one.e_k_mv == other.e_k_mv && one.refractory_ms == other.refractory_ms &&
           (one.delta_g == 0) == (other.delta_g == 0) &&
           dense::steps_class(one, scan_interval) == dense::steps_class(other, scan_interval);
}

using Indices = std::vector<DensePopulation::Index>;

// The neurons of each part, in order.
std::vector<Indices> parts_of(std::span<const LifParameters> parameters, Duration scan_interval) {
    require(!parameters.empty(), "parameters", "given for at least one neuron", 0);
    std::vector<Indices> parts;
    for (DensePopulation::Index i = 0; i < parameters.size(); ++i) {
        parameters[i].check();
        const auto part = std::find_if(parts.begin(), parts.end(), [&](const Indices& each) {
            return alike(parameters[each.front()], parameters[i], scan_interval);
        });
        if (part == parts.end())
            parts.push_back({i});
        else
            part->push_back(i);
    }
    return parts;
}

std::vector<LifParameters> chosen(std::span<const LifParameters> parameters, const Indices& indices) {
    std::vector<LifParameters> result;
    for (const DensePopulation::Index i : indices) result.push_back(parameters[i]);
    return result;
}

LifParameters with_largest_adaptation(std::span<const LifParameters> each) {
    return *std::max_element(
        each.begin(), each.end(),
        [](const LifParameters& one, const LifParameters& other) { return one.delta_g < other.delta_g; });
}

std::uint64_t with_index(std::uint64_t key, DensePopulation::Index index) { return key >> 32 << 32 | index; }

}  // namespace

std::shared_ptr<DenseScratch> make_dense_scratch(std::size_t neurons) {
    return std::make_shared<DenseScratch>(neurons);
}

struct DensePopulation::Part {
    DenseSweeper sweeper;
    Indices indices;  // of its neurons; empty: all of them

    Index index(std::size_t i) const noexcept { return indices.empty() ? static_cast<Index>(i) : indices[i]; }
};

std::optional<std::string> DensePopulation::refusal(const NeuronModel& model, Duration scan_interval) {
    try {
        dense::check(lif(model), scan_interval);
    } catch (const ParameterError& error) {
        return error.what();
    }
    return std::nullopt;
}

bool DensePopulation::pays(const LifParameters& parameters, Duration scan_interval) {
    return dense::steps_class(parameters, scan_interval) <= dense::most_steps;
}

DensePopulation::DensePopulation(const NeuronModel& model, std::size_t count, Duration scan_interval,
                                 SpikeLimit limit, Phases phases, std::shared_ptr<DenseScratch> scratch)
    : scan_interval_(scan_interval),
      size_(count),
      scratch_(scratch ? std::move(scratch) : make_dense_scratch()),
      phases_(std::move(phases)) {
    parts_.push_back({DenseSweeper(lif(model), {}, count, scan_interval, limit, scratch_), {}});
    reset();
}

DensePopulation::DensePopulation(std::span<const LifParameters> parameters, Duration scan_interval,
                                 SpikeLimit limit, Phases phases, std::shared_ptr<DenseScratch> scratch)
    : scan_interval_(scan_interval),
      size_(parameters.size()),
      scratch_(scratch ? std::move(scratch) : make_dense_scratch()),
      phases_(std::move(phases)) {
    std::vector<Indices> parts = parts_of(parameters, scan_interval);
    for (Indices& indices : parts) {
        const std::vector<LifParameters> each = chosen(parameters, indices);
        DenseSweeper sweeper(with_largest_adaptation(each), each, each.size(), scan_interval, limit,
                             scratch_);
        parts_.push_back({std::move(sweeper), parts.size() > 1 ? std::move(indices) : Indices{}});
    }
    if (parts_.size() > 1) {
        scratch_->drives_mv.resize(std::max(scratch_->drives_mv.size(), size_));
        scratch_->all_keys.reserve(2 * size_);
    }
    reset();
}

DensePopulation::~DensePopulation() = default;
DensePopulation::DensePopulation(DensePopulation&&) noexcept = default;
DensePopulation& DensePopulation::operator=(DensePopulation&&) noexcept = default;

std::size_t DensePopulation::size_of(const LifParameters& parameters, std::size_t count) noexcept {
    return sizeof(DensePopulation) + sizeof(Part) - sizeof(DenseSweeper) +
           DenseSweeper::size_of(parameters, {}, count);
}

std::size_t DensePopulation::size_of(std::span<const LifParameters> parameters, Duration scan_interval) {
    const std::vector<Indices> parts = parts_of(parameters, scan_interval);
    std::size_t sum = sizeof(DensePopulation);
    for (const Indices& indices : parts) {
        const std::vector<LifParameters> each = chosen(parameters, indices);
        sum += sizeof(Part) - sizeof(DenseSweeper) +
               DenseSweeper::size_of(with_largest_adaptation(each), each, each.size());
        if (parts.size() > 1) sum += indices.size() * sizeof(Index);
    }
    return sum;
}

std::size_t DensePopulation::bytes() const noexcept {
    std::size_t sum = sizeof *this;
    for (const Part& part : parts_)
        sum += sizeof part - sizeof part.sweeper + part.sweeper.bytes() + part.indices.size() * sizeof(Index);
    return sum;
}

std::span<double> DensePopulation::take_drives() {
    return scratch_->columns.drives_mv.take(size_).first(size_);
}

const char* DensePopulation::instructions() const noexcept { return parts_.front().sweeper.instructions(); }

void DensePopulation::reset() {
    for (Part& part : parts_)
        part.sweeper.reset([&](Index i) { return phases_ ? phases_(part.index(i)) : 0; });
    storm_.reset();
    time_ = scene_start;
}

void DensePopulation::for_each_state(const std::function<void(Index, const LifState&)>& use) const {
    for (const Part& part : parts_)
        part.sweeper.for_each_state([&](Index i, const LifState& state) { use(part.index(i), state); });
}

void DensePopulation::restore(TimePoint time, const std::function<LifState(Index)>& state_of) {
    for (Part& part : parts_) part.sweeper.restore([&](Index i) { return state_of(part.index(i)); });
    time_ = time;
}

template <class Use>
void DensePopulation::sweep_parts(std::span<const double> drives_mv, Use&& use) {
    std::vector<double>& own_mv = scratch_->drives_mv;
    for (Part& part : parts_) {
        std::span<const double> drives = drives_mv;
        if (!part.indices.empty()) {
            for (std::size_t i = 0; i < part.indices.size(); ++i) own_mv[i] = drives_mv[part.indices[i]];
            drives = std::span(own_mv).first(part.indices.size());
        }
        use(part, drives);
        if (const auto& storm = part.sweeper.storm(); storm && !storm_)
            storm_ = SpikeStorm{part.index(storm->index), storm->time};
    }
}

std::span<const std::uint64_t> DensePopulation::spikes(std::span<const double> drives_mv) {
    std::vector<std::uint64_t>& all = scratch_->all_keys;
    all.clear();
    std::span<const std::uint64_t> keys;
    sweep_parts(drives_mv, [&](Part& part, std::span<const double> drives) {
        keys = part.sweeper.sweep(drives, time_);
        if (part.indices.empty()) return;
        for (const std::uint64_t key : keys)
            all.push_back(with_index(key, part.indices[static_cast<Index>(key)]));
    });
    return parts_.size() > 1 ? std::span<const std::uint64_t>(all) : keys;
}

DensePopulation::Unrounded DensePopulation::unrounded_spikes(std::span<const double> drives_mv) {
    std::vector<std::uint64_t>& all = scratch_->all_keys;
    std::vector<double>& all_times_ns = scratch_->all_times_ns;
    all.clear();
    all_times_ns.clear();
    sweep_parts(drives_mv, [&](Part& part, std::span<const double> drives) {
        const std::span<const double> times_ns = part.sweeper.sweep_unrounded(drives, time_);
        for (const std::uint64_t key : part.sweeper.keys())
            all.push_back(with_index(key, part.index(static_cast<Index>(key))));
        all_times_ns.insert(all_times_ns.end(), times_ns.begin(), times_ns.end());
    });
    return {all, all_times_ns};
}

}  // namespace afferent
