// The kinds of afferents against the literature. docs/afferents.md has the tables that this test computes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/scene/patch.hpp"
#include "afferent/scene/plan.hpp"
#include "tests/shared_data.hpp"

namespace afferent {
namespace {

// A flat-ended probe on an elastic half-space, indented by d: the pressure at a distance r from its axis is
// E* d / (π √(a² − r²)), and the force 2 a E* d, of which equal steps of √(a² − r²) carry equal parts.
constexpr double modulus_n_per_mm2 = 0.05;
constexpr double poisson = 0.4;
constexpr double contact_modulus = modulus_n_per_mm2 / (1 - poisson * poisson);

// The forces on the elements for an indentation of 1 mm.
std::vector<double> punch_n(const ElementGrid& grid, double radius_mm) {
    constexpr int steps = 200;
    constexpr int angles = 400;
    std::vector<double> forces_n(grid.elements());
    const double part_n = 2 * radius_mm * contact_modulus / (steps * angles);
    const double columns =
        std::round((grid.place(grid.elements() - 1).x_mm - grid.place(0).x_mm) / grid.pitch_mm()) + 1;
    for (int i = 0; i < steps; ++i) {
        const double s = (i + 0.5) / steps;
        const double r_mm = radius_mm * std::sqrt(1 - s * s);
        for (int k = 0; k < angles; ++k) {
            const double angle = 2 * std::numbers::pi * (k + 0.5) / angles;
            const double column = std::round((r_mm * std::cos(angle) - grid.place(0).x_mm) / grid.pitch_mm());
            const double row = std::round((r_mm * std::sin(angle) - grid.place(0).y_mm) / grid.pitch_mm());
            forces_n[static_cast<std::size_t>(row * columns + column)] += part_n;
        }
    }
    return forces_n;
}

// Dawson's integral, e^(−x²) ∫₀ˣ e^(t²) dt, by the midpoint rule.
double dawson(double x) {
    constexpr int steps = 10'000;
    double sum = 0;
    for (int i = 0; i < steps; ++i) sum += std::exp(std::pow((i + 0.5) / steps * x, 2) - x * x);
    return sum * x / steps;
}

struct Stimulus {
    bool ramp = false;
    double amplitude_mm = 0;
    double frequency_hz = 0;
    double ramp_s = 0.05;
    double duration_s = 1;
    double radius_mm = 0.5;
    double distance_mm = 0;
    double sampling_hz = 5000;

    double indentation_mm(double t) const {
        const double rise = std::clamp(std::min(t, duration_s - t) / ramp_s, 0.0, 1.0);
        return amplitude_mm * rise * (ramp ? 1 : std::sin(2 * std::numbers::pi * frequency_hz * t));
    }
};

struct Response {
    double rate_hz = 0;
    double first_spike_ms = std::nan("");
};

// One afferent, at a distance from the probe, without the differences between afferents.
class OneAfferent {
  public:
    OneAfferent(scene::Kind kind, double distance_mm, double radius_mm)
        : leaves_skin_(kind == scene::Kind::sa1),
          plan_(make_plan(scene_of(kind, distance_mm))),
          coprocessor_(plan_),
          punch_n_(punch_n(*plan_.patches[0].grid, radius_mm)),
          forces_n_(punch_n_.size()) {}

    // What it reads for an indentation of 1 mm, in N on a square millimetre.
    double felt_n() const { return plan_.patches[0].fields.sum(0, punch_n_); }

    // A probe that vibrates leaves the skin where it draws back from it, for a kind that feels pressure; for
    // those that feel its changes, it vibrates about an indentation that has been held.
    Response to(const Stimulus& stimulus) {
        coprocessor_.reset();
        Response response;
        std::uint64_t spikes = 0;
        const auto samples = static_cast<std::uint64_t>(stimulus.duration_s * stimulus.sampling_hz);
        for (std::uint64_t i = 0; i <= samples; ++i) {
            const TimePoint time = sample_time(i, stimulus.sampling_hz);
            double indentation_mm = stimulus.indentation_mm(seconds(time));
            if (leaves_skin_) indentation_mm = std::max(0.0, indentation_mm);
            for (std::size_t k = 0; k < forces_n_.size(); ++k) forces_n_[k] = indentation_mm * punch_n_[k];
            coprocessor_.push({time, 0, forces_n_});
            for (const Event& event : coprocessor_.advance(time))
                if (++spikes == 1) response.first_spike_ms = 1000 * seconds(event.time);
        }
        response.rate_hz = static_cast<double>(spikes) / stimulus.duration_s;
        return response;
    }

    // The smallest amplitude of a vibration of half a second to which it answers at all.
    double threshold_um(double frequency_hz) {
        double silent_mm = 1e-6;
        double heard_mm = 1;
        while (heard_mm / silent_mm > 1.01) {
            const double tried_mm = std::sqrt(silent_mm * heard_mm);
            const Stimulus stimulus{.amplitude_mm = tried_mm,
                                    .frequency_hz = frequency_hz,
                                    .duration_s = 0.5,
                                    .sampling_hz = std::max(2000.0, 20 * frequency_hz)};
            (to(stimulus).rate_hz > 0 ? heard_mm : silent_mm) = tried_mm;
        }
        return 1000 * heard_mm;
    }

    double best_frequency_hz(std::initializer_list<double> frequencies_hz) {
        double best_hz = 0;
        double lowest_um = HUGE_VAL;
        for (const double frequency_hz : frequencies_hz)
            if (const double um = threshold_um(frequency_hz); um < lowest_um) {
                lowest_um = um;
                best_hz = frequency_hz;
            }
        return best_hz;
    }

  private:
    static Scene scene_of(scene::Kind kind, double distance_mm) {
        Scene scene;
        scene.patches = {scene::preset(kind)};
        scene::Patch& patch = scene.patches[0];
        patch.name = "skin";
        patch.spread = {};
        patch.outline = scene::Outline{.shape = scene::Rectangle{2 * distance_mm + 3, 3}, .pitch_mm = 0.125};
        patch.afferents->place = {{distance_mm, 0}};
        scene.source = scene::Pushed();
        scene.record = {.events = true, .force = false, .picture = false};
        return scene;
    }

    bool leaves_skin_;
    Plan plan_;
    Coprocessor coprocessor_;
    std::vector<double> punch_n_;
    std::vector<double> forces_n_;
};

// The mean of the pressure under a Gaussian field of deviation σ around the probe's axis is
// E* d √2 / (π σ) · D(a / (√2 σ)), with Dawson's integral D.
TEST(Literature, PressureAtTheAfferentIsThatOfAHalfSpace) {
    for (const scene::Kind kind : {scene::Kind::sa1, scene::Kind::pc})
        for (const double radius_mm : {0.5, 1.0}) {
            const double sd_mm = scene::preset(kind).afferents->field_sd_mm;
            const double expected_n = contact_modulus * std::numbers::sqrt2 / (std::numbers::pi * sd_mm) *
                                      dawson(radius_mm / (std::numbers::sqrt2 * sd_mm));
            // Elements move a force by up to half of 0.125 mm; the field leaves 1 % out.
            EXPECT_NEAR(OneAfferent(kind, 0, radius_mm).felt_n() / expected_n, 1, 0.03) << radius_mm;
        }
}

// ---- the eleven responses ----

struct Row {
    std::string kind;
    std::string conduction;
    Stimulus stimulus;
    Response literature;
};

std::vector<Row> rows_of(const std::filesystem::path& file) {
    std::vector<Row> rows;
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) {
        std::vector<std::string> fields;
        std::istringstream cells(line);
        for (std::string cell; std::getline(cells, cell, ',');) fields.push_back(cell);
        const auto number = [&](std::size_t i) { return fields.at(i).empty() ? 0 : std::stod(fields.at(i)); };
        rows.push_back({fields.at(0),
                        fields.at(9),
                        {.ramp = fields.at(1) == "ramp",
                         .amplitude_mm = number(2),
                         .frequency_hz = number(3),
                         .ramp_s = number(4) / 1000,
                         .duration_s = number(5),
                         .radius_mm = number(6),
                         .distance_mm = number(7),
                         .sampling_hz = number(8)},
                        {number(10), number(11)}});
    }
    return rows;
}

scene::Kind kind_named(const std::string& name) {
    return name == "SA1" ? scene::Kind::sa1 : name == "RA" ? scene::Kind::ra : scene::Kind::pc;
}

std::string number(double value, int digits) {
    if (std::isnan(value)) return "none";
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.*f", digits, value);
    return text.data();
}

std::string table_row(const Row& row, const Response& response) {
    const Stimulus& s = row.stimulus;
    std::ostringstream text;
    text << "| " << row.kind << " | " << (s.ramp ? "ramp " : "sine ") << s.amplitude_mm << " mm";
    if (!s.ramp) text << ", " << s.frequency_hz << " Hz";
    if (s.distance_mm > 0) text << ", " << s.distance_mm << " mm away";
    text << " | " << s.sampling_hz << " | " << number(row.literature.rate_hz, 0) << " | "
         << number(response.rate_hz, 0) << " | " << number(row.literature.first_spike_ms, 1)
         << (row.conduction == "yes" ? ", conducted" : "") << " | " << number(response.first_spike_ms, 1)
         << " |";
    return text.str();
}

// How far from the literature a response may be: a spike and the quarter of a millisecond that the literature
// itself allows, but where a leaky integrator with adaptation, or what is before it, cannot do that.
Response allowance(const Row& row) {
    const Stimulus& s = row.stimulus;
    // A pressure that comes and goes cannot drive a neuron of this form more than one that stays.
    if (row.kind == "SA1" && !s.ramp) return {33, 0.75};
    // Nerves have no length here.
    if (row.conduction == "yes") return {1, 5.25};
    // A slope is known at the sample that ends it, 10 ms later.
    if (row.kind == "RA" && s.sampling_hz == 100) return {1, 5.5};
    if (row.kind == "RA" && !s.ramp) return {3, 0.75};
    // Each of the four corners of a ramp is the same to a rectified second derivative.
    if (row.kind == "PC" && s.ramp) return {3, 0.25};
    // No wave travels through the skin.
    if (s.distance_mm > 0) return {row.literature.rate_hz, HUGE_VAL};
    if (row.kind == "PC") return {1, s.sampling_hz < 5000 ? 1.25 : 0.5};
    return {1, 0.25};
}

TEST(Literature, ElevenResponsesOfSingleAfferents) {
    const auto file = shared_data() / "afferent_responses.csv";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file << " to compare with";
    std::ifstream in(AFFERENT_SOURCE_DIR "/docs/afferents.md");
    const std::string documented{std::istreambuf_iterator<char>(in), {}};
    const std::vector<Row> rows = rows_of(file);
    ASSERT_EQ(rows.size(), 11U);
    for (const Row& row : rows) {
        OneAfferent afferent(kind_named(row.kind), row.stimulus.distance_mm, row.stimulus.radius_mm);
        const Response response = afferent.to(row.stimulus);
        const std::string text = table_row(row, response);
        const Response allowed = allowance(row);
        EXPECT_NEAR(response.rate_hz, row.literature.rate_hz, allowed.rate_hz) << text;
        if (std::isfinite(allowed.first_spike_ms)) {
            EXPECT_NEAR(response.first_spike_ms, row.literature.first_spike_ms, allowed.first_spike_ms)
                << text;
        }
        EXPECT_NE(documented.find(text), std::string::npos) << "docs/afferents.md should have\n" << text;
    }
}

// Freeman and Johnson (1982), Bolanowski et al. (1988).
TEST(Literature, BestFrequenciesOfRaAndPc) {
    const double ra_hz = OneAfferent(scene::Kind::ra, 0, 0.5)
                             .best_frequency_hz({10, 20, 30, 35, 40, 45, 50, 55, 60, 70, 100, 200});
    EXPECT_GE(ra_hz, 40);
    EXPECT_LE(ra_hz, 60);
    const double pc_hz = OneAfferent(scene::Kind::pc, 0, 0.5)
                             .best_frequency_hz({50, 100, 150, 200, 225, 250, 275, 300, 400, 600});
    EXPECT_GE(pc_hz, 200);
    EXPECT_LE(pc_hz, 300);
}

// Johansson and Vallbo (1979): 9.2 µm, 13.8 µm and 56.5 µm in the median. Each kind at its best frequency,
// SA1 at the slowest that fits.
TEST(Literature, ThresholdsRiseFromPcOverRaToSa1) {
    const double pc_um = OneAfferent(scene::Kind::pc, 0, 0.5).threshold_um(250);
    const double ra_um = OneAfferent(scene::Kind::ra, 0, 0.5).threshold_um(45);
    const double sa1_um = OneAfferent(scene::Kind::sa1, 0, 0.5).threshold_um(5);
    EXPECT_LT(pc_um, ra_um);
    EXPECT_LT(ra_um, sa1_um);
    EXPECT_NEAR(std::log(ra_um / 13.8), 0, std::log(1.5)) << "the same to a factor of 1.5";
    EXPECT_NEAR(std::log(sa1_um / 56.5), 0, std::log(1.5));
    std::ifstream in(AFFERENT_SOURCE_DIR "/docs/afferents.md");
    const std::string documented{std::istreambuf_iterator<char>(in), {}};
    const std::string told = "PC " + number(pc_um, 2) + " µm at 250 Hz, RA " + number(ra_um, 0) +
                             " µm at 45 Hz, SA1 " + number(sa1_um, 0) + " µm";
    EXPECT_NE(documented.find(told), std::string::npos) << "docs/afferents.md should have\n" << told;
}

}  // namespace
}  // namespace afferent
