#include "afferent/nodes/emg_signal.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>

#include "afferent/hand/user.hpp"
#include "afferent/io/files/column_unit.hpp"

namespace afferent {
namespace {

constexpr double lowest_hz = 20;
constexpr double highest_hz = 450;
constexpr double most_of_rate = 0.45;  // a filter needs its corner below half of the rate
// Muscles make a raw signal cross its median some 100 times a second and more; an envelope, which is smoothed
// below 10 Hz, cannot do it half as often as this.
constexpr double fewest_raw_crossings_hz = 40;
// Below this rate a band from 20 Hz is too narrow to be told from an envelope.
constexpr double slowest_raw_hz = 100;
constexpr double strongest_part = 0.99;
constexpr double rest_part = 0.05;

double quantile(std::vector<double> values, double part) {
    const auto at =
        values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

std::string in_millivolts(double volts) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.4g mV", 1e3 * volts);
    return text.data();
}

std::string whole(double value) { return std::to_string(std::llround(value)); }

// Second order, Butterworth, by the bilinear transformation with its corner prewarped (Oppenheim and Schafer,
// Discrete-Time Signal Processing):
//
//     y = b0 x + b1 x' + b2 x'' − a1 y' − a2 y''
class Butterworth {
  public:
    enum class Pass { low, high };
    Butterworth(Pass pass, double corner_hz, double rate_hz) {
        const double k = std::tan(std::numbers::pi * corner_hz / rate_hz);
        const double scale = 1 / (1 + std::numbers::sqrt2 * k + k * k);
        b0_ = scale * (pass == Pass::low ? k * k : 1);
        b1_ = (pass == Pass::low ? 2 : -2) * b0_;
        a1_ = 2 * scale * (k * k - 1);
        a2_ = scale * (1 - std::numbers::sqrt2 * k + k * k);
    }
    double operator()(double x) {
        const double y = b0_ * x + w1_;
        w1_ = b1_ * x - a1_ * y + w2_;
        w2_ = b0_ * x - a2_ * y;
        return y;
    }

  private:
    double b0_, b1_, a1_, a2_;
    double w1_ = 0;
    double w2_ = 0;
};

double rate_of(const Table& table) {
    if (table.rows() < 2) return 0;
    std::vector<double> intervals;
    for (std::size_t i = 1; i < table.rows(); ++i)
        intervals.push_back(seconds(table.times[i] - table.times[i - 1]));
    return 1 / quantile(std::move(intervals), 0.5);
}

bool is_raw(std::span<const double> centred, double rate_hz) {
    if (rate_hz < slowest_raw_hz) return false;
    std::size_t crossings = 0;
    for (std::size_t i = 1; i < centred.size(); ++i)
        if ((centred[i] > 0) != (centred[i - 1] > 0)) ++crossings;
    return static_cast<double>(crossings) * rate_hz >=
           fewest_raw_crossings_hz * static_cast<double>(centred.size());
}

// No electrode gives more volts than this, and hardly any converter as few counts.
constexpr double most_volts = 10;

bool are_counts(std::span<const double> values) {
    if (std::ranges::any_of(values, [](double value) { return std::abs(value) > most_volts; })) return true;
    return std::ranges::all_of(values, [](double value) { return value >= 0 && value == std::floor(value); });
}

// As the controller smooths it.
double strongest_envelope(std::span<const double> signal, double rate_hz, double envelope_ms) {
    const double step = rate_hz > 0 ? -std::expm1(-1e3 / (rate_hz * envelope_ms)) : 1;
    std::vector<double> envelope;
    envelope.reserve(signal.size());
    double smoothed = 0;
    for (const double value : signal) envelope.push_back(smoothed += step * (std::abs(value) - smoothed));
    return quantile(std::move(envelope), strongest_part);
}

std::vector<double> band_passed(std::span<const double> signal, double rate_hz, double to_hz) {
    Butterworth high(Butterworth::Pass::high, lowest_hz, rate_hz);
    Butterworth low(Butterworth::Pass::low, to_hz, rate_hz);
    std::vector<double> passed;
    passed.reserve(signal.size());
    for (const double value : signal) passed.push_back(low(high(value)));
    return passed;
}

}  // namespace

EmgReading read_emg(Table table, const scene::EmgTable& asked, double envelope_ms) {
    const std::string about = "EMG: column \"" + table.columns.front() + "\" is ";
    const auto named = unit_of_column(table.columns.front());
    const bool volts = asked.unit == scene::EmgUnit::volts ||
                       (asked.unit == scene::EmgUnit::by_name && !asked.rest_counts &&
                        (named ? named->quantity == Quantity::volts : !are_counts(table.values)));
    const bool asks_for_counts = asked.unit == scene::EmgUnit::counts || !volts;
    if (asks_for_counts && asked.signal == scene::EmgSignal::automatic)
        return {{std::move(table.times), std::move(table.values), {}}, ""};

    const double rate_hz = rate_of(table);
    const double factor = named && named->quantity == Quantity::volts ? named->factor : 1;
    const double middle = quantile(table.values, 0.5);
    std::vector<double> signal;
    for (const double value : table.values) signal.push_back(factor * (value - middle));
    const bool raw = asked.signal == scene::EmgSignal::raw ||
                     (asked.signal == scene::EmgSignal::automatic && is_raw(signal, rate_hz));
    const auto amount = [&](double value) {
        return asks_for_counts ? whole(value) + " counts" : in_millivolts(value);
    };

    std::string said = about + (asks_for_counts ? "in counts" : "in volts");
    double strongest = 0;
    if (raw) {
        const double to_hz = std::min(highest_hz, most_of_rate * rate_hz);
        said += ", raw";
        if (to_hz > 2 * lowest_hz) {
            signal = band_passed(signal, rate_hz, to_hz);
            said += ", band-passed from " + whole(lowest_hz) + " to " + whole(to_hz) + " Hz";
        } else {
            said += ", at " + whole(rate_hz) + " Hz too slow to be band-passed";
        }
        strongest = strongest_envelope(signal, rate_hz, envelope_ms);
    } else {
        const double rest = quantile(signal, rest_part);
        for (double& value : signal) value = std::max(0.0, value - rest);
        said += ", an envelope without its level at rest of " + amount(rest + factor * middle);
        strongest = quantile(signal, strongest_part);
    }
    const double full_scale = !asks_for_counts && asked.full_scale_v ? *asked.full_scale_v : strongest;
    said += ", scaled so that " + amount(full_scale) +
            (!asks_for_counts && asked.full_scale_v ? "" : ", which it exceeds 1 % of the time,") +
            " is the strongest contraction";
    // A recording without any contraction stays at rest.
    const double counts_per_unit = full_scale > 0 ? asked.full_scale_counts / full_scale : 0;
    for (double& value : signal) value = User::rest_counts + counts_per_unit * value;
    return {{std::move(table.times), std::move(signal), User::rest_counts}, std::move(said)};
}

}  // namespace afferent
