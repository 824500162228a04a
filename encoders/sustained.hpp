// The sustained kind: a drive in proportion to force, as slowly adapting afferents respond.
#pragma once

#include "afferent/encoders/encoder.hpp"

namespace afferent {

//     drive = gain · force + bias
class Sustained {
  public:
    struct Parameters {
        double gain_mv_per_n;
        double bias_mv = 0;

        // Throws ParameterError: gain_mv_per_n > 0, both finite.
        void check() const;

        // What every encoder in the list of encoders/encoders.hpp tells of itself.
        static constexpr const char* name = "sustained";
        static constexpr const char* gain_name = "gain_mv_per_n";
        static constexpr EncoderInput input = EncoderInput::force;
        static constexpr bool decodable() noexcept { return true; }
        double gain_of_input() const noexcept { return gain_mv_per_n; }
        static Seconds settling() noexcept { return Seconds(0); }
        static Parameters with(double gain, double bias_mv) noexcept { return {gain, bias_mv}; }
        static double largest_input(double range_n, std::optional<Interval>) noexcept { return range_n; }
    };
    struct State {};

    // Throws ParameterError.
    explicit Sustained(const Parameters& parameters);

    double drive_mv(State&, TimePoint, double force_n) const noexcept { return gain_ * force_n + bias_; }

  private:
    double gain_;
    double bias_;
};

static_assert(Encoder<Sustained>);

}  // namespace afferent
