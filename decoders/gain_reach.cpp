#include "afferent/decoders/gain_reach.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdio>
#include <numeric>
#include <vector>

#include "afferent/decoders/grip_estimator.hpp"

namespace afferent {
namespace {

// The highest hundredth of a sensor's range tells nothing: noise and the converter's steps carry readings to
// its end. The filter takes readings above this part of it for censored.
constexpr double usable_range = 0.98;
// How many standard deviations of what is not known have room beyond the limit.
constexpr double sigmas_to_spare = 2;
// A gain that closes for good at this many times its limit still keeps a hand there: until then it is 0 most
// of the time and nearly so in the rest, in which the hand creeps. In random closed loops (`afferent bench
// decoding`) no force of a counting decoder stayed beyond its limit where the gain closed below 1.3 times of
// it, 2 of 27 did from there to 1.5 times, and three of four from twice the limit on.
constexpr double tolerated = 1.3;
// Until the next spike a decoder goes by the last, whatever the force does. A hand whose gain is nearly
// closed creeps, and within a second does not get far: in those closed loops forces ran away from there on.
// The filter's belief drains meanwhile, and its forces ran away below three spikes a second.
constexpr double longest_wait_of_others_s = 1;
constexpr double longest_wait_of_filter_s = 1 / 3.0;
// How exactly the force is sought from which on a gain is 0.
constexpr double exactness = 0.005;
// Beyond so many times the limit nobody asks for the force any more.
constexpr double most_limits = 100;

// Regular trains where they tell the least: for a window or a kernel just before the next spike.
class LowestRates {
  public:
    LowestRates(const DecodedAfferents& afferents, double window_s)
        : of_address_(afferents.addresses, 0), window_s_(window_s) {}

    void set(Address address, double rate_hz) {
        sum_hz_ += rate_hz - of_address_[address];
        of_address_[address] = rate_hz;
    }

    // As SpikeCounts: counts in a known second.
    double events() const noexcept { return sum_hz_; }
    double events_of(Address address) const noexcept { return of_address_[address]; }
    double known_s() const noexcept { return 1; }
    double window_s() const noexcept { return window_s_; }
    double short_hz(double) const noexcept { return 0; }
    // The limit is to be reached by what is counted, and not by doubt.
    double allowed_hz() const noexcept { return 0; }
    double allowed_hz_of(Address) const noexcept { return 0; }
    double spike_hz() const noexcept { return 0; }

  private:
    std::vector<double> of_address_;
    double sum_hz_ = 0;
    double window_s_;
};

bool tells_held_force(const DecodedAfferents& decoded, const DecodedAfferents::Afferent& afferent) {
    return afferent.share > 0 && decoded.groups[afferent.group].drive_mv_per_n > 0;
}

// Rates of all groups at a grip force that is being loaded, as their sensors feel it.
std::vector<double> steady_rates_hz(const DecodedAfferents& decoded, double grip_n) {
    std::vector<double> rates_hz;
    for (const DecodedAfferents::Group& group : decoded.groups) {
        const double felt_n = std::min((1 - decoded.hysteresis) * grip_n, usable_range * group.full_scale_n);
        rates_hz.push_back(group.drive_mv_per_n > 0 ? group.rate_hz(RateKind::steady, felt_n) : 0);
    }
    return rates_hz;
}

// Where afferents differ one by one, so many of them, evenly spaced by address, stand for all.
constexpr std::size_t most_groups = 1024;

DecodedAfferents representatives_of(const DecodedAfferents& all) {
    if (all.groups.size() <= most_groups) return all;
    DecodedAfferents some = all;
    some.groups.clear();
    some.afferents.clear();
    const std::size_t stride = all.afferents.size() / most_groups;
    for (std::size_t i = 0; i < all.afferents.size(); i += stride) {
        DecodedAfferents::Afferent afferent = all.afferents[i];
        some.groups.push_back(all.groups[afferent.group]);
        afferent.group = static_cast<std::uint32_t>(some.groups.size() - 1);
        some.afferents.push_back(afferent);
    }
    return some;
}

class Reach {
  public:
    explicit Reach(const GainLoop& loop)
        : decoder_(loop.decoder),
          decoded_(representatives_of(loop.afferents)),
          gain_parameters_(loop.gain),
          gain_(gain_parameters_) {}

    // As result().reaches(), without the search.
    bool reaches() const {
        const double tolerated_n = tolerated * gain_parameters_.limit_n;
        return GainReach{.limit_n = gain_parameters_.limit_n,
                         .sensed_n = sensed_n(),
                         .wanted_n = wanted_n(),
                         .rate_hz = rate_at_limit_hz(),
                         .longest_wait_s = longest_wait(),
                         .closes_n = tolerated_n}
                   .reaches() &&
               std::visit(
                   [&](const auto& decoder) {
                       return Lowest<std::decay_t<decltype(decoder)>>(*this, decoder).closed(tolerated_n);
                   },
                   decoder_);
    }

    GainReach result() const {
        return {.limit_n = gain_parameters_.limit_n,
                .sensed_n = sensed_n(),
                .wanted_n = wanted_n(),
                .rate_hz = rate_at_limit_hz(),
                .longest_wait_s = longest_wait(),
                .closes_n = std::visit([this](const auto& decoder) { return closes_n(decoder); }, decoder_)};
    }

  private:
    // Where others than the filter add what elements tell, those at full scale hold the sum down.
    double sensed_n() const {
        const bool filter = std::holds_alternative<FilterParameters>(decoder_);
        double sum_n = 0;
        double shares = 0;
        double largest_n = 0;
        for (const DecodedAfferents::Afferent& afferent : decoded_.afferents) {
            if (!tells_held_force(decoded_, afferent)) continue;
            const double full_scale_n = usable_range * decoded_.groups[afferent.group].full_scale_n;
            sum_n += afferent.share * full_scale_n;
            shares += afferent.share;
            largest_n = std::max(largest_n, full_scale_n);
        }
        return filter ? largest_n : sum_n / shares;
    }

    // Of what all elements tell together, as a part of it: gains of their own average out, what they have in
    // common does not.
    double relative_sigma() const {
        double shares = 0;
        double squares = 0;
        for (const DecodedAfferents::Afferent& afferent : decoded_.afferents) {
            if (!tells_held_force(decoded_, afferent)) continue;
            shares += afferent.share;
            squares += afferent.share * afferent.share;
        }
        const Uncertainty& of = decoded_.uncertainty;
        const double own = of.gain * of.gain * squares / (shares * shares);
        return std::sqrt(own + of.common_gain * of.common_gain + of.hysteresis * of.hysteresis);
    }

    double rate_at_limit_hz() const {
        const std::vector<double> rates_hz = steady_rates_hz(decoded_, gain_parameters_.limit_n);
        double sum_hz = 0;
        double afferents = 0;
        for (const DecodedAfferents::Afferent& afferent : decoded_.afferents) {
            if (!tells_held_force(decoded_, afferent)) continue;
            sum_hz += rates_hz[afferent.group];
            ++afferents;
        }
        return sum_hz / afferents;
    }

    double longest_wait() const {
        return std::holds_alternative<FilterParameters>(decoder_) ? longest_wait_of_filter_s
                                                                  : longest_wait_of_others_s;
    }

    double wanted_n() const { return gain_parameters_.limit_n * (1 + sigmas_to_spare * relative_sigma()); }

    // Whether the gain stays 0 at a grip force, by decoders of counts and intervals,
    template <class Parameters>
    class Lowest {
      public:
        Lowest(const Reach& reach, const Parameters& parameters)
            : reach_(reach),
              parameters_(parameters),
              estimator_(GripEstimator::of(reach.decoded_, parameters.curve, parameters.pooling)),
              rates_(reach.decoded_, parameters.window_s()) {}

        bool closed(double grip_n) {
            const std::vector<double> rates_hz = steady_rates_hz(reach_.decoded_, grip_n);
            for (const DecodedAfferents::Afferent& afferent : reach_.decoded_.afferents)
                rates_.set(afferent.address, parameters_.trough_hz(rates_hz[afferent.group]));
            return reach_.gain_(estimator_(rates_)) == 0;
        }

      private:
        const Reach& reach_;
        const Parameters& parameters_;
        GripEstimator estimator_;
        LowestRates rates_;
    };
    // and by those that model the drive, which know the force between spikes as well.
    template <class Parameters>
    requires std::same_as<Parameters, InversionParameters> || std::same_as<Parameters, FilterParameters>
    class Lowest<Parameters> {
      public:
        Lowest(const Reach& reach, const Parameters&) : limit_n_(reach.gain_parameters_.limit_n) {}
        bool closed(double grip_n) const { return grip_n >= limit_n_; }

      private:
        double limit_n_;
    };

    template <class Parameters>
    std::optional<double> closes_n(const Parameters& parameters) const {
        Lowest<Parameters> lowest(*this, parameters);
        double least_n = gain_parameters_.limit_n;
        double most_n = tolerated * least_n;
        if (lowest.closed(least_n)) return least_n;
        if (!lowest.closed(most_n)) {
            least_n = most_n;
            most_n = most_limits * gain_parameters_.limit_n;
            if (!lowest.closed(most_n)) return std::nullopt;
        }
        while (most_n > (1 + exactness) * least_n) {
            const double middle_n = std::sqrt(least_n * most_n);
            (lowest.closed(middle_n) ? most_n : least_n) = middle_n;
        }
        return most_n;
    }

    const DecoderParameters& decoder_;
    const DecodedAfferents decoded_;
    const EmgGain::Parameters& gain_parameters_;
    EmgGain gain_;
};

std::string to_text(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g", value);
    return text.data();
}

std::string milliseconds(Duration duration) { return to_text(Milliseconds(duration).count()) + " ms"; }

struct DecoderText {
    double rate_hz;
    std::string operator()(const SlidingWindowParameters& window) const {
        const double spikes = rate_hz * seconds(window.window);
        std::string text = ", and a window of " + milliseconds(window.window);
        if (spikes < 1) return text + " is empty " + to_text(100 * (1 - spikes)) + " % of the time";
        return text + " holds as few as " + to_text(std::floor(spikes)) + " of the spikes";
    }
    std::string operator()(const ExponentialParameters& kernel) const {
        return ", and a rate over " + milliseconds(kernel.time_constant) + " falls to " +
               to_text(kernel.trough_hz(rate_hz)) + " Hz from one spike to the next";
    }
    template <class Other>
    std::string operator()(const Other&) const {
        return "";
    }
};

}  // namespace

bool GainReach::closes_at_limit() const noexcept { return closes_n && *closes_n <= tolerated * limit_n; }

bool GainReach::hears_in_time() const noexcept { return rate_hz * longest_wait_s >= 1; }

GainReach gain_reach(const GainLoop& loop) { return Reach(loop).result(); }

std::string unreachable_limit(const GainLoop& loop) {
    const Reach found(loop);
    if (found.reaches()) return "";
    const GainReach reach = found.result();
    std::string text = "limit_n is " + to_text(reach.limit_n) + " N: ";
    if (!reach.senses_limit()) {
        text += "the sensors read " + to_text(reach.sensed_n) + " N at most";
        if (reach.sensed_n >= reach.limit_n)
            text += ", and as well as they are known they have to read " + to_text(reach.wanted_n) + " N";
        return text;
    }
    text += "there an afferent fires " + to_text(reach.rate_hz) + " times a second once adapted" +
            std::visit(DecoderText{reach.rate_hz}, loop.decoder);
    if (!reach.closes_n) return text + ": no force brings the gain to 0 for good";
    if (!reach.closes_at_limit())
        return text + ": the gain is 0 for good only from " + to_text(*reach.closes_n) + " N on";
    return text + ", and a force may rise unnoticed for " + to_text(1 / reach.rate_hz) + " s";
}

}  // namespace afferent
