#include "afferent/neurons/dense_sweeper.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

using dense::Batch;

LifParameters without_period(LifParameters parameters) {
    parameters.refractory_ms = 0;
    return parameters;
}

std::size_t tiles(std::size_t count) { return (count + dense::tile - 1) / dense::tile; }

// Two spikes for each neuron in a scan interval, and one more for each of a batch.
std::size_t room_for_keys(std::size_t count) { return 2 * count + Batch::capacity; }

// Neurons of a tile for which there is room in its list from the beginning; the list grows where more rest at
// once.
constexpr std::size_t usually_resting = dense::tile / 8;

// In units of tau_g: then the factor of the conductances is taken into each of them.
constexpr double longest_scaled = 8;

using Number = double LifParameters::*;

bool differs(std::span<const LifParameters> each, Number number) {
    return std::ranges::any_of(each,
                               [&](const LifParameters& one) { return one.*number != each.front().*number; });
}

// The arrays of what neurons have of their own.
std::size_t own_arrays(std::span<const LifParameters> each) {
    return std::size_t{differs(each, &LifParameters::v_th_mv)} + differs(each, &LifParameters::delta_g);
}

void put(Batch& to, std::size_t at, const Batch& from, std::size_t i) noexcept {
    to.gap_mv[at] = from.gap_mv[i];
    to.g[at] = from.g[i];
    to.excess_mv[at] = from.excess_mv[i];
    to.end_mv[at] = from.end_mv[i];
    to.left[at] = from.left[i];
    to.elapsed[at] = from.elapsed[i];
    to.index[at] = from.index[i];
}

template <class Condition>
void keep_if(Batch& batch, Condition&& condition) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < batch.size; ++i)
        if (condition(static_cast<std::size_t>(batch.index[i]))) put(batch, kept++, batch, i);
    batch.size = kept;
}

}  // namespace

DenseSweeper::DenseSweeper(const LifParameters& parameters, std::span<const LifParameters> each,
                           std::size_t count, Duration scan_interval, SpikeLimit limit,
                           std::shared_ptr<DenseScratch> scratch)
    : scratch_(std::move(scratch)),
      plan_(scratch_->plan(dense::planned(parameters), scan_interval)),
      kernel_(dense::kernel()),
      neuron_(without_period(parameters)),
      membrane_(parameters),
      parameters_(parameters),
      scan_interval_ns_(static_cast<double>(scan_interval.count())),
      count_(count),
      period_(Interval(Milliseconds(parameters.refractory_ms)).count() / plan_->model.tau_ns),
      gap_mv_(scratch_->columns.gap_mv.take(count)) {
    require(limit.window > Duration(0), "window", "> 0 ns", static_cast<double>(limit.window.count()));
    const double share = scan_interval_ns_ / plan_->steps / static_cast<double>(limit.window.count());
    spikes_per_step_ = std::ceil(limit.spikes * share);
    forgets_ = plan_->model.step > longest_scaled * plan_->model.a;
    dense::Columns& columns = scratch_->columns;
    if (adapts()) scaled_g_ = columns.scaled_g.take(count);
    // The padding has the last neuron's.
    const auto own = [&](std::span<double>& numbers, dense::Column& column, Number number) {
        if (!differs(each, number)) return;
        numbers = column.take(count);
        for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = each[std::min(i, count - 1)].*number;
    };
    own(v_th_mv_, columns.v_th_mv, &LifParameters::v_th_mv);
    own(delta_g_, columns.delta_g, &LifParameters::delta_g);
    keys_.reserve(room_for_keys(count));
    if (period_ > 0) {
        rests_.resize(count);
        resting_.resize(tiles(count));
        for (auto& of_tile : resting_) of_tile.reserve(std::min(usually_resting, count));
    }
}

void DenseSweeper::reset(const Phases& phase_of) {
    storm_.reset();
    for (std::size_t i = 0; i < gap_mv_.size(); ++i) {
        gap_mv_[i] = v_th_mv(i) - plan_->model.v_r_mv;
        if (i < count_) gap_mv_[i] *= 1 - phase_of(static_cast<Index>(i));
    }
    std::ranges::fill(scaled_g_, 0.0);
    passed_ = 0;
    std::fill(rests_.begin(), rests_.end(), std::uint8_t{0});
    for (auto& of_tile : resting_) of_tile.clear();
}

std::span<const std::uint64_t> DenseSweeper::sweep(std::span<const double> drives_mv, TimePoint begin) {
    assert(drives_mv.size() == count_);
    keys_.clear();
    for (int step = 0; step <= plan_->steps; ++step)
        scales_[static_cast<std::size_t>(step)] = scale_after(forgets_ ? std::min(step, 1) : passed_ + step);
    for (Batch* const batch : {&scratch_->first, &scratch_->again, &scratch_->after}) batch->size = 0;
    for (std::size_t tile = 0; tile < count_; tile += dense::tile) {
        const std::size_t size = std::min(dense::tile, count_ - tile);
        const bool last = plan_->steps > 1 || tile + size == count_;
        for (int step = 0; step < plan_->steps; ++step) {
            carry(drives_mv, tile, size, step, last, begin);
            if (forgets_) rescale(tile, size, end_scale_);
        }
    }
    if (!forgets_) passed_ += plan_->steps;
    if (static_cast<double>(passed_) * plan_->model.step > longest_scaled * plan_->model.a) {
        rescale(0, count_, scale_after(passed_));
        passed_ = 0;
    }
    return keys_;
}

std::span<const double> DenseSweeper::sweep_unrounded(std::span<const double> drives_mv, TimePoint begin) {
    unrounded_ = true;
    times_ns_.clear();
    sweep(drives_mv, begin);
    unrounded_ = false;
    return times_ns_;
}

std::size_t DenseSweeper::bytes() const noexcept {
    std::size_t resting = rests_.size() + resting_.size() * sizeof(std::vector<Resting>);
    for (const auto& of_tile : resting_) resting += of_tile.capacity() * sizeof(Resting);
    const std::size_t numbers = gap_mv_.size() + scaled_g_.size() + v_th_mv_.size() + delta_g_.size();
    return sizeof *this + numbers * sizeof(double) + resting;
}

std::size_t DenseSweeper::size_of(const LifParameters& parameters, std::span<const LifParameters> each,
                                  std::size_t count) noexcept {
    std::size_t resting = 0;
    if (parameters.refractory_ms > 0)
        resting = count + tiles(count) * (sizeof(std::vector<Resting>) +
                                          std::min(usually_resting, count) * sizeof(Resting));
    const std::size_t arrays = std::size_t{1} + (parameters.delta_g > 0) + own_arrays(each);
    return sizeof(DenseSweeper) + dense::padded(count) * arrays * sizeof(double) + resting;
}

void DenseSweeper::for_each_state(const std::function<void(Index, const LifState&)>& use) const {
    for (std::size_t i = 0; i < count_; ++i)
        if (rests_.empty() || rests_[i] == 0)
            use(static_cast<Index>(i),
                {gap_mv_[i], adapts() ? scaled_g_[i] * scale_after(passed_) : 0, Interval(0)});
    for (const auto& of_tile : resting_)
        for (const Resting& one : of_tile)
            use(one.index, {gap_mv_[one.index], one.g, Interval(one.left * plan_->model.tau_ns)});
}

void DenseSweeper::restore(const std::function<LifState(Index)>& state_of) {
    std::fill(rests_.begin(), rests_.end(), std::uint8_t{0});
    for (auto& of_tile : resting_) of_tile.clear();
    passed_ = 0;
    end_scale_ = 1;
    for (std::size_t i = 0; i < count_; ++i) {
        const LifState state = state_of(static_cast<Index>(i));
        gap_mv_[i] = state.gap_mv;
        store_g(i, state.g);
        const double left = state.refractory_left.count() / plan_->model.tau_ns;
        if (left > 0) begin_rest(i, left, state.g);
    }
}

void DenseSweeper::rescale(std::size_t begin, std::size_t count, double scale) noexcept {
    if (adapts())
        for (double& g : scaled_g_.subspan(begin, count)) g *= scale;
}

void DenseSweeper::carry(std::span<const double> drives_mv, std::size_t tile, std::size_t size, int step,
                         bool last, TimePoint begin) {
    const auto from = static_cast<std::size_t>(forgets_ ? 0 : step);
    end_scale_ = scales_[from + 1];
    const dense::Neurons neurons{.gap_mv = gap_mv_.data(),
                                 .scaled_g = scaled_g_.data(),
                                 .v_th_mv = v_th_mv_.data(),
                                 .delta_g = delta_g_.data(),
                                 .common_v_th_mv = parameters_.v_th_mv,
                                 .common_delta_g = parameters_.delta_g,
                                 .rest = period_ > 0,
                                 .scale = scales_[from],
                                 .end_scale = end_scale_};
    const double start_ns = scan_interval_ns_ * step / plan_->steps;
    Batch& first = scratch_->first;
    hard_.size = 0;
    const std::size_t whole = size / kernel_.lanes * kernel_.lanes;
    kernel_.sweep(plan_->model, neurons, drives_mv.data() + tile, tile, whole, first, hard_);
    if (whole < size) {
        std::array<double, dense::max_lanes> rest{};
        std::copy_n(drives_mv.data() + tile + whole, size - whole, rest.data());
        // The padding of the last vector stays at rest, whatever its threshold.
        std::fill(rest.begin() + static_cast<std::ptrdiff_t>(size - whole), rest.end(), 0.0);
        kernel_.sweep(plan_->model, neurons, rest.data(), tile + whole, kernel_.lanes, first, hard_);
        keep_if(hard_, [&](std::size_t index) { return index < count_; });
    }
    if (period_ > 0) release(resting_[tile / dense::tile], neurons, drives_mv, first);
    if (plan_->series)
        fire_crossings(neurons, start_ns, last, begin);
    else
        leave_to_carry_alone(first);
    for (std::size_t i = 0; i < hard_.size; ++i) carry_alone(i, drives_mv, start_ns, begin);
}

// A group takes much less time than its crossings one by one. So those that do not fill a group wait for the
// next tile, and those that cross again, which are few, for more tiles.
void DenseSweeper::fire_crossings(const dense::Neurons& neurons, double start_ns, bool last,
                                  TimePoint begin) {
    constexpr std::size_t most_waiting = dense::tile / 2;
    Batch& first = scratch_->first;
    Batch* crossing = &scratch_->again;
    Batch* again = &scratch_->after;
    if (first.size > 0 && spikes_per_step_ < 1)
        return note_storm(static_cast<std::size_t>(first.index[0]), begin);
    fire(neurons, start_ns, first, last ? first.size : first.size / kernel_.group * kernel_.group, *crossing);
    if (!last && crossing->size <= most_waiting) return;
    for (double fired = 1; crossing->size > 0; ++fired) {
        if (fired >= spikes_per_step_) {
            note_storm(static_cast<std::size_t>(crossing->index[0]), begin);
            break;
        }
        fire(neurons, start_ns, *crossing, crossing->size, *again);
        std::swap(crossing, again);
    }
    crossing->size = 0;  // those that storm
}

void DenseSweeper::fire(const dense::Neurons& neurons, double start_ns, Batch& crossing, std::size_t count,
                        Batch& again) {
    const std::size_t waiting = crossing.size - count;
    crossing.size = count;
    const std::size_t used = keys_.size();
    keys_.resize(used + count + dense::max_lanes);
    if (unrounded_) times_ns_.resize(keys_.size());
    released_.size = 0;
    const std::size_t fired = kernel_.fire(plan_->model, neurons, start_ns, scan_interval_ns_, crossing,
                                           period_ > 0 ? released_ : again, hard_, keys_.data() + used,
                                           unrounded_ ? times_ns_.data() + used : nullptr);
    keys_.resize(used + fired);
    if (unrounded_) times_ns_.resize(used + fired);
    if (period_ > 0) {
        rest(neurons, released_);
        kernel_.finish(plan_->model, neurons, released_, again, hard_);
    }
    for (std::size_t i = 0; i < waiting; ++i) put(crossing, i, crossing, count + i);
    crossing.size = waiting;
}

void DenseSweeper::release(std::vector<Resting>& resting, const dense::Neurons& neurons,
                           std::span<const double> drives_mv, Batch& crossing) {
    if (resting.empty()) return;
    for (Batch* const batch : {&crossing, &hard_})
        keep_if(*batch, [&](std::size_t index) { return rests_[index] == 0; });
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
    if (plan_->series)
        kernel_.finish(plan_->model, neurons, released_, crossing, hard_);
    else
        leave_to_carry_alone(released_);
}

void DenseSweeper::rest(const dense::Neurons& neurons, Batch& batch) {
    const double step = plan_->model.step;
    std::size_t awake = 0;
    for (std::size_t i = 0; i < batch.size; ++i) {
        const auto index = static_cast<std::size_t>(batch.index[i]);
        const double until = batch.elapsed[i] + period_;
        if (until >= step) {
            const double g = plan_->model.adapts ? batch.g[i] * kept(step - batch.elapsed[i]) : 0;
            begin_rest(index, until - step, g);
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

void DenseSweeper::begin_rest(std::size_t index, double left, double g) {
    resting_[index / dense::tile].push_back({static_cast<Index>(index), left, g});
    rests_[index] = 1;
    store_g(index, g);
}

void DenseSweeper::leave_to_carry_alone(Batch& batch) noexcept {
    for (std::size_t i = 0; i < batch.size; ++i) put(hard_, hard_.size++, batch, i);
    batch.size = 0;
}

void DenseSweeper::carry_alone(std::size_t at, std::span<const double> drives_mv, double start_ns,
                               TimePoint begin) {
    const auto index = static_cast<std::size_t>(hard_.index[at]);
    const double drive_mv = drives_mv[index];
    const AdaptingLif neuron = neuron_.varied(v_th_mv(index), delta_g(index));
    AdaptingLif::State state{hard_.gap_mv[at], adapts() ? hard_.g[at] : 0};
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
            note_storm(index, begin);
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
        begin_rest(index, (period_ns - held_ns) / plan_->model.tau_ns, state.g);
        break;
    }
    gap_mv_[index] = state.gap_mv;
    store_g(index, state.g);
}

}  // namespace afferent
