#include "afferent/neurons/dense_population.hpp"

#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include "afferent/neurons/adapting_lif.hpp"
#include "afferent/neurons/dense_plan.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

using dense::Batch;
using Doubles = hwy::AlignedFreeUniquePtr<double[]>;

// The parameters that all neurons share, with the largest Δg.
LifParameters common(std::span<const LifParameters> each) {
    require(!each.empty(), "parameters", "given for at least one neuron", 0);
    LifParameters common = each.front();
    for (const LifParameters& one : each) {
        one.check();
        const auto same = [](double value, double first, const char* field) {
            require(value == first, field, "the same for all neurons of a dense population", value);
        };
        same(one.tau_m_ms, common.tau_m_ms, "tau_m_ms");
        same(one.tau_g_ms, common.tau_g_ms, "tau_g_ms");
        same(one.v_r_mv, common.v_r_mv, "v_r_mv");
        same(one.e_k_mv, common.e_k_mv, "e_k_mv");
        same(one.refractory_ms, common.refractory_ms, "refractory_ms");
        common.delta_g = std::max(common.delta_g, one.delta_g);
    }
    return common;
}

// Up to a quarter of an octave: populations whose largest Δg are nearly the same share a plan.
LifParameters rounded_up(LifParameters parameters) {
    if (parameters.delta_g > 0)
        parameters.delta_g = std::exp2(std::ceil(4 * std::log2(parameters.delta_g)) / 4);
    return parameters;
}

LifParameters without_period(LifParameters parameters) {
    parameters.refractory_ms = 0;
    return parameters;
}

// The only model whose solution the polynomials are.
const LifParameters& lif(const NeuronModel& model) {
    if (const auto* parameters = std::get_if<LifParameters>(&model)) return *parameters;
    throw ParameterError("neuron", "lif for the dense form, which evaluates its exact solution", name(model));
}

std::size_t padded(std::size_t count) {
    return (count + dense::max_lanes - 1) / dense::max_lanes * dense::max_lanes;
}

std::size_t tiles(std::size_t count) { return (count + dense::tile - 1) / dense::tile; }

// Two spikes for each neuron in a scan interval, and one more for each of a tile.
std::size_t room_for_keys(std::size_t count) { return 2 * count + dense::tile + dense::max_lanes; }

// Of a tile; more make room when they come.
constexpr std::size_t usually_resting = dense::tile / 8;

// In units of tau_g: then the factor of the conductances is taken into each of them.
constexpr double longest_scaled = 8;

bool adaptation_differs(std::span<const LifParameters> each) {
    return std::any_of(each.begin(), each.end(),
                       [&](const LifParameters& one) { return one.delta_g != each.front().delta_g; });
}

}  // namespace

struct DenseScratch {
    Batch batch;
    Batch after;
    Batch hard;
    Batch released;
    std::vector<std::uint64_t> keys;
    std::vector<double> times_ns;  // of the keys, if they are asked for

    std::shared_ptr<const dense::Plan> plan(const LifParameters& parameters, Duration scan_interval) {
        for (const Planned& each : plans)
            if (each.parameters == parameters && each.scan_interval == scan_interval) return each.plan;
        plans.push_back({parameters, scan_interval,
                         std::make_shared<const dense::Plan>(dense::plan(parameters, scan_interval))});
        return plans.back().plan;
    }

  private:
    struct Planned {
        LifParameters parameters;
        Duration scan_interval;
        std::shared_ptr<const dense::Plan> plan;
    };
    std::vector<Planned> plans;
};

std::shared_ptr<DenseScratch> make_dense_scratch() { return std::make_shared<DenseScratch>(); }

class DensePopulation::Sweeper {
  public:
    Sweeper(const LifParameters& parameters, std::span<const LifParameters> each, std::size_t count,
            Duration scan_interval, SpikeLimit limit, std::span<const double> phases,
            std::shared_ptr<DenseScratch> scratch)
        : scratch_(scratch ? std::move(scratch) : make_dense_scratch()),
          plan_(scratch_->plan(rounded_up(without_period(parameters)), scan_interval)),
          kernel_(dense::kernel()),
          neuron_(without_period(parameters)),
          membrane_(parameters),
          parameters_(parameters),
          scan_interval_ns_(static_cast<double>(scan_interval.count())),
          count_(count),
          period_(Interval(Milliseconds(parameters.refractory_ms)).count() / plan_->model.tau_ns),
          padded_(padded(count)),
          phases_(phases.begin(), phases.end()),
          gap_mv_(hwy::AllocateAligned<double>(padded_)) {
        require(limit.window > Duration(0), "window", "> 0 ns", static_cast<double>(limit.window.count()));
        const double share = scan_interval_ns_ / plan_->steps / static_cast<double>(limit.window.count());
        spikes_per_step_ = std::ceil(limit.spikes * share);
        if (plan_->model.adapts) scaled_g_ = hwy::AllocateAligned<double>(padded_);
        if (!each.empty()) {
            v_th_mv_ = hwy::AllocateAligned<double>(padded_);
            if (adaptation_differs(each)) delta_g_ = hwy::AllocateAligned<double>(padded_);
            for (std::size_t i = 0; i < padded_; ++i) {
                const LifParameters& own = i < count ? each[i] : parameters;
                v_th_mv_[i] = own.v_th_mv;
                if (delta_g_) delta_g_[i] = own.delta_g;
            }
        }
        keys_.reserve(room_for_keys(count));
        if (period_ > 0) {
            rests_.resize(count);
            resting_.resize(tiles(count));
            for (auto& of_tile : resting_) of_tile.reserve(std::min(usually_resting, count));
        }
        reset();
    }

    void reset() noexcept {
        storm_.reset();
        for (std::size_t i = 0; i < padded_; ++i) {
            gap_mv_[i] = v_th_mv(i) - plan_->model.v_r_mv;
            if (i < phases_.size()) gap_mv_[i] *= 1 - phases_[i];
            if (scaled_g_) scaled_g_[i] = 0;
        }
        passed_ = 0;
        std::fill(rests_.begin(), rests_.end(), std::uint8_t{0});
        for (auto& of_tile : resting_) of_tile.clear();
    }

    std::span<const std::uint64_t> sweep(std::span<const double> drives_mv, TimePoint begin) {
        assert(drives_mv.size() == count_);
        keys_.clear();
        for (std::size_t tile = 0; tile < count_; tile += dense::tile) {
            const std::size_t size = std::min(dense::tile, count_ - tile);
            for (int step = 0; step < plan_->steps; ++step) carry(drives_mv, tile, size, step, begin);
        }
        passed_ += plan_->steps;
        if (static_cast<double>(passed_) * plan_->model.step > longest_scaled * plan_->model.a) rescale();
        return keys_;
    }
    std::span<const double> sweep_unrounded(std::span<const double> drives_mv, TimePoint begin) {
        unrounded_ = true;
        times_ns_.clear();
        sweep(drives_mv, begin);
        unrounded_ = false;
        return times_ns_;
    }
    std::span<const std::uint64_t> keys() const noexcept { return keys_; }

    std::size_t size() const noexcept { return count_; }
    std::size_t bytes() const noexcept {
        const int arrays = 1 + (scaled_g_ != nullptr) + (v_th_mv_ != nullptr) + (delta_g_ != nullptr);
        std::size_t resting = rests_.size() + resting_.size() * sizeof(std::vector<Resting>);
        for (const auto& of_tile : resting_) resting += of_tile.capacity() * sizeof(Resting);
        return sizeof *this + padded_ * static_cast<std::size_t>(arrays) * sizeof(double) +
               phases_.size() * sizeof(double) + resting;
    }

    static std::size_t size_of(const Content& content) noexcept {
        const std::size_t arrays =
            std::size_t{1} + content.adapts + content.individual + content.adaptation_differs;
        std::size_t resting = 0;
        if (content.refractory)
            resting = content.count +
                      tiles(content.count) * (sizeof(std::vector<Resting>) +
                                              std::min(usually_resting, content.count) * sizeof(Resting));
        return sizeof(Sweeper) + padded(content.count) * arrays * sizeof(double) +
               content.phases * sizeof(double) + resting;
    }

    void for_each_state(const std::function<void(Index, const LifState&)>& use) const {
        for (std::size_t i = 0; i < count_; ++i)
            if (rests_.empty() || rests_[i] == 0)
                use(static_cast<Index>(i),
                    {gap_mv_[i], scaled_g_ ? scaled_g_[i] * scale_after(passed_) : 0, Interval(0)});
        for (const auto& of_tile : resting_)
            for (const Resting& one : of_tile)
                use(one.index, {gap_mv_[one.index], one.g, Interval(one.left * plan_->model.tau_ns)});
    }
    void restore(const std::function<LifState(Index)>& state_of) {
        std::fill(rests_.begin(), rests_.end(), std::uint8_t{0});
        for (auto& of_tile : resting_) of_tile.clear();
        passed_ = 0;
        end_scale_ = 1;
        for (std::size_t i = 0; i < count_; ++i) {
            const LifState state = state_of(static_cast<Index>(i));
            gap_mv_[i] = state.gap_mv;
            store_g(i, state.g);
            const double left = state.refractory_left.count() / plan_->model.tau_ns;
            if (left > 0) begin_rest(resting_[i / dense::tile], i, left, state.g);
        }
    }
    const char* instructions() const noexcept { return kernel_.name; }
    const std::optional<SpikeStorm>& storm() const noexcept { return storm_; }

  private:
    // A neuron in its refractory period at the end of a step, with what is left of the period and its
    // conductance at that time.
    struct Resting {
        Index index;
        double left;  // in units of tau_m
        double g;
    };

    double v_th_mv(std::size_t index) const noexcept {
        return v_th_mv_ ? v_th_mv_[index] : parameters_.v_th_mv;
    }

    // By which g decays in so many steps.
    double scale_after(std::int64_t steps) const noexcept {
        return scaled_g_ ? std::exp(-static_cast<double>(steps) * plan_->model.step / plan_->model.a) : 1;
    }
    // g at the end of the step.
    void store_g(std::size_t index, double g) noexcept {
        if (scaled_g_) scaled_g_[index] = g / end_scale_;
    }
    void rescale() noexcept {
        const double scale = scale_after(passed_);
        if (scaled_g_)
            for (std::size_t i = 0; i < padded_; ++i) scaled_g_[i] *= scale;
        passed_ = 0;
    }

    void carry(std::span<const double> drives_mv, std::size_t tile, std::size_t size, int step,
               TimePoint begin) {
        end_scale_ = scale_after(passed_ + step + 1);
        const dense::Neurons neurons{.gap_mv = gap_mv_.get(),
                                     .scaled_g = scaled_g_.get(),
                                     .v_th_mv = v_th_mv_.get(),
                                     .delta_g = delta_g_.get(),
                                     .common_v_th_mv = parameters_.v_th_mv,
                                     .common_delta_g = parameters_.delta_g,
                                     .rest = period_ > 0,
                                     .scale = scale_after(passed_ + step),
                                     .end_scale = end_scale_};
        const double start_ns = scan_interval_ns_ * step / plan_->steps;
        Batch* crossing = &scratch_->batch;
        Batch* after = &scratch_->after;
        crossing->size = 0;
        hard_.size = 0;
        const std::size_t whole = size / kernel_.lanes * kernel_.lanes;
        kernel_.sweep(plan_->model, neurons, drives_mv.data() + tile, tile, whole, *crossing, hard_);
        if (whole < size) {
            std::array<double, dense::max_lanes> rest{};
            std::copy_n(drives_mv.data() + tile + whole, size - whole, rest.data());
            // The padding of the last vector stays at rest, whatever its threshold.
            std::fill(rest.begin() + static_cast<std::ptrdiff_t>(size - whole), rest.end(), 0.0);
            kernel_.sweep(plan_->model, neurons, rest.data(), tile + whole, kernel_.lanes, *crossing, hard_);
        }
        if (period_ > 0) release(resting_[tile / dense::tile], neurons, drives_mv, *crossing);
        for (double fired = 1; crossing->size > 0; ++fired) {
            if (fired > spikes_per_step_) {
                note_storm(static_cast<Index>(crossing->index[0]), begin);
                break;
            }
            const std::size_t used = keys_.size();
            keys_.resize(used + crossing->size + dense::max_lanes);
            if (unrounded_) times_ns_.resize(keys_.size());
            after->size = 0;
            const std::size_t more =
                kernel_.fire(plan_->model, neurons, start_ns, scan_interval_ns_, *crossing, *after, hard_,
                             keys_.data() + used, unrounded_ ? times_ns_.data() + used : nullptr);
            keys_.resize(used + more);
            if (unrounded_) times_ns_.resize(used + more);
            if (period_ > 0) {
                rest(resting_[tile / dense::tile], neurons, *after);
                crossing->size = 0;
                kernel_.finish(plan_->model, neurons, *after, *crossing, hard_);
            } else {
                std::swap(crossing, after);
            }
        }
        for (std::size_t i = 0; i < hard_.size; ++i) carry_alone(i, drives_mv, start_ns, begin);
    }

    // The factor by which g decays in that time.
    double kept(double units) const noexcept { return std::exp(-units / plan_->model.a); }
    double fall_or_decay(double units) const noexcept {
        return plan_->model.adapts ? std::expm1(-units / plan_->model.a) : std::exp(-units);
    }

    void put(Batch& to, std::size_t at, const Batch& from, std::size_t i) const noexcept {
        to.gap_mv[at] = from.gap_mv[i];
        to.g[at] = from.g[i];
        to.excess_mv[at] = from.excess_mv[i];
        to.end_mv[at] = from.end_mv[i];
        to.left[at] = from.left[i];
        to.elapsed[at] = from.elapsed[i];
        to.index[at] = from.index[i];
    }

    // The sweep has advanced neurons in their refractory period like the others; their results are
    // overwritten here. They rest to the end of the step or continue from where their period ends.
    void release(std::vector<Resting>& resting, const dense::Neurons& neurons,
                 std::span<const double> drives_mv, Batch& crossing) {
        if (resting.empty()) return;
        for (Batch* const batch : {&crossing, &hard_}) {
            std::size_t awake = 0;
            for (std::size_t i = 0; i < batch->size; ++i)
                if (rests_[static_cast<std::size_t>(batch->index[i])] == 0) put(*batch, awake++, *batch, i);
            batch->size = awake;
        }
        const double step = plan_->model.step;
        released_.size = 0;
        std::erase_if(resting, [&](Resting& one) {
            const Membrane membrane = membrane_.with_threshold(v_th_mv(one.index));
            if (one.left >= step) {
                one.left -= step;
                one.g *= kept(step);
                gap_mv_[one.index] = membrane.reset_gap_mv();
                store_g(one.index, one.g);
                return false;
            }
            const std::size_t at = released_.size++;
            released_.gap_mv[at] = membrane.reset_gap_mv();
            released_.g[at] = one.g * kept(one.left);
            released_.excess_mv[at] = membrane.excess_mv(drives_mv[one.index]);
            released_.left[at] = fall_or_decay(step - one.left);
            released_.elapsed[at] = one.left;
            released_.index[at] = one.index;
            rests_[one.index] = 0;
            return true;
        });
        kernel_.finish(plan_->model, neurons, released_, crossing, hard_);
    }

    // Every neuron of the batch has just fired.
    void rest(std::vector<Resting>& resting, const dense::Neurons& neurons, Batch& batch) {
        const double step = plan_->model.step;
        std::size_t awake = 0;
        for (std::size_t i = 0; i < batch.size; ++i) {
            const auto index = static_cast<std::size_t>(batch.index[i]);
            const double until = batch.elapsed[i] + period_;
            if (until >= step) {
                const double g = plan_->model.adapts ? batch.g[i] * kept(step - batch.elapsed[i]) : 0;
                begin_rest(resting, index, until - step, g);
                neurons.gap_mv[index] = batch.gap_mv[i];
                continue;
            }
            put(batch, awake, batch, i);
            batch.elapsed[awake] = until;
            batch.left[awake] = fall_or_decay(step - until);
            if (plan_->model.adapts) batch.g[awake] *= kept(period_);
            ++awake;
        }
        batch.size = awake;
    }

    void begin_rest(std::vector<Resting>& resting, std::size_t index, double left, double g) {
        resting.push_back({static_cast<Index>(index), left, g});
        rests_[index] = 1;
        store_g(index, g);
    }

    // Advances one neuron by AdaptingLif, from where the batch left it to the end of the step.
    void carry_alone(std::size_t at, std::span<const double> drives_mv, double start_ns, TimePoint begin) {
        const auto index = static_cast<std::size_t>(hard_.index[at]);
        const double drive_mv = drives_mv[index];
        const AdaptingLif neuron =
            neuron_.varied(v_th_mv(index), delta_g_ ? delta_g_[index] : parameters_.delta_g);
        AdaptingLif::State state{hard_.gap_mv[at], scaled_g_ ? hard_.g[at] : 0};
        const double end_ns = start_ns + plan_->model.step * plan_->model.tau_ns;
        double now_ns = start_ns + hard_.elapsed[at] * plan_->model.tau_ns;
        for (double fired = 0;; ++fired) {
            AdaptingLif::State end = state;
            neuron.advance(end, drive_mv, Interval(std::max(0.0, end_ns - now_ns)));
            if (!(end.gap_mv <= 0)) {
                state = end;
                break;
            }
            if (fired >= spikes_per_step_) {
                note_storm(static_cast<Index>(index), begin);
                break;
            }
            // Rounding must not put the spike after the end of the step.
            const Interval span(std::min(neuron.next_spike(state, drive_mv).count(), end_ns - now_ns));
            neuron.fire_after(state, span);
            now_ns += span.count();
            const double stamp_ns = std::clamp(std::ceil(now_ns), 1.0, scan_interval_ns_);
            keys_.push_back(static_cast<std::uint64_t>(stamp_ns) << 32 | index);
            if (unrounded_) times_ns_.push_back(now_ns);
            if (period_ <= 0) continue;
            const double period_ns = period_ * plan_->model.tau_ns;
            const double held_ns = std::min(period_ns, end_ns - now_ns);
            neuron.hold(state, Interval(held_ns));
            now_ns += held_ns;
            if (held_ns >= period_ns) continue;
            begin_rest(resting_[index / dense::tile], index, (period_ns - held_ns) / plan_->model.tau_ns,
                       state.g);
            break;
        }
        gap_mv_[index] = state.gap_mv;
        store_g(index, state.g);
    }

    void note_storm(Index index, TimePoint begin) noexcept {
        if (!storm_) storm_ = SpikeStorm{index, begin};
    }

    std::shared_ptr<DenseScratch> scratch_;
    std::shared_ptr<const dense::Plan> plan_;
    dense::Kernel kernel_;
    AdaptingLif neuron_;
    Membrane membrane_;
    LifParameters parameters_;  // of all; where each has its own, the largest Δg
    double scan_interval_ns_;
    double spikes_per_step_ = 0;
    std::size_t count_;
    std::int64_t passed_ = 0;  // steps since scaled_g_ was g itself
    double end_scale_ = 1;     // of g, at the end of the step that is carried out
    double period_;            // refractory, in units of tau_m; 0 if there is none
    std::size_t padded_;
    std::vector<double> phases_;  // at the beginning; empty: all at rest
    Batch& hard_ = scratch_->hard;
    Batch& released_ = scratch_->released;
    std::vector<std::uint64_t>& keys_ = scratch_->keys;
    std::vector<double>& times_ns_ = scratch_->times_ns;
    Doubles gap_mv_;
    Doubles scaled_g_;
    Doubles v_th_mv_;
    Doubles delta_g_;
    std::vector<std::vector<Resting>> resting_;  // by tile
    std::vector<std::uint8_t> rests_;            // by neuron: 1 in its refractory period
    bool unrounded_ = false;
    std::optional<SpikeStorm> storm_;
};

std::optional<std::string> DensePopulation::refusal(const NeuronModel& model, Duration scan_interval) {
    try {
        dense::plan(lif(model), scan_interval);
    } catch (const ParameterError& error) {
        return error.what();
    }
    return std::nullopt;
}

DensePopulation::DensePopulation(const NeuronModel& model, std::size_t count, Duration scan_interval,
                                 SpikeLimit limit, std::span<const double> phases,
                                 std::shared_ptr<DenseScratch> scratch)
    : scan_interval_(scan_interval),
      sweeper_(std::make_unique<Sweeper>(lif(model), std::span<const LifParameters>{}, count, scan_interval,
                                         limit, phases, std::move(scratch))) {}

DensePopulation::DensePopulation(std::span<const LifParameters> parameters, Duration scan_interval,
                                 SpikeLimit limit, std::span<const double> phases,
                                 std::shared_ptr<DenseScratch> scratch)
    : scan_interval_(scan_interval),
      sweeper_(std::make_unique<Sweeper>(common(parameters), parameters, parameters.size(), scan_interval,
                                         limit, phases, std::move(scratch))) {}

DensePopulation::~DensePopulation() = default;
DensePopulation::DensePopulation(DensePopulation&&) noexcept = default;
DensePopulation& DensePopulation::operator=(DensePopulation&&) noexcept = default;

std::size_t DensePopulation::size() const noexcept { return sweeper_->size(); }
std::size_t DensePopulation::size_of(const Content& content) noexcept {
    return sizeof(DensePopulation) + Sweeper::size_of(content);
}
std::size_t DensePopulation::bytes() const noexcept { return sizeof *this + sweeper_->bytes(); }
const char* DensePopulation::instructions() const noexcept { return sweeper_->instructions(); }
const std::optional<SpikeStorm>& DensePopulation::storm() const noexcept { return sweeper_->storm(); }

void DensePopulation::reset() noexcept {
    sweeper_->reset();
    time_ = scene_start;
}

void DensePopulation::for_each_state(const std::function<void(Index, const LifState&)>& use) const {
    sweeper_->for_each_state(use);
}

void DensePopulation::restore(TimePoint time, const std::function<LifState(Index)>& state_of) {
    sweeper_->restore(state_of);
    time_ = time;
}

std::span<const std::uint64_t> DensePopulation::spikes(std::span<const double> drives_mv) {
    return sweeper_->sweep(drives_mv, time_);
}

DensePopulation::Unrounded DensePopulation::unrounded_spikes(std::span<const double> drives_mv) {
    const std::span<const double> times_ns = sweeper_->sweep_unrounded(drives_mv, time_);
    return {sweeper_->keys(), times_ns};
}

}  // namespace afferent
