// The kinds of afferents against the literature. docs/afferents.md has the tables that this test computes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/hand/disc_contact.hpp"
#include "afferent/scene/patch.hpp"
#include "afferent/scene/plan.hpp"
#include "tests/long_runs.hpp"
#include "tests/shared_data.hpp"

namespace afferent {
namespace {

// A flat-ended probe on the elastic half-space of the defaults.
constexpr double contact_modulus = 0.05 / (1 - 0.4 * 0.4);  // E* of 50 kPa, in N/mm²

// The forces on the elements for an indentation of 1 mm at a place on the x axis.
std::vector<double> punch_n(const ElementGrid& grid, double radius_mm, double at_mm = 0) {
    const DiscContact punch{.tip = DiscContact::Tip::flat,
                            .radius_mm = radius_mm,
                            .load_n = DiscContact::flat_n(1, radius_mm, ElasticSkin()),
                            .aperture = Aperture(grid.pitch_mm())};
    std::vector<double> forces_n(grid.elements());
    for (std::uint32_t i = 0; i < grid.elements(); ++i)
        forces_n[i] = punch.force_n({grid.place(i).x_mm - at_mm, grid.place(i).y_mm});
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
        // A wave asks for times before the beginning, when the probe was not there.
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
    OneAfferent(scene::Kind kind, double distance_mm, double radius_mm, bool conducted = false,
                std::optional<scene::Outline> outline = {})
        : leaves_skin_(kind == scene::Kind::sa1 || kind == scene::Kind::sa1_dynamic),
          plan_(make_plan(scene_of(kind, distance_mm, conducted, std::move(outline)))),
          coprocessor_(plan_),
          punch_n_(punch_n(*plan_.patches[0].grid, radius_mm)),
          wave_(distance_mm > 0 ? wave_of(*plan_.patches[0].grid, distance_mm, radius_mm)
                                : std::vector<Wave>()),
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
            for (const Wave& wave : wave_)
                forces_n_[wave.element] +=
                    wave.force_n * stimulus.indentation_mm(seconds(time) - wave.delay_s);
            coprocessor_.push({time, 0, forces_n_});
            for (const Event& event : coprocessor_.advance(time))
                if (++spikes == 1) response.first_spike_ms = 1000 * seconds(event.time);
        }
        response.rate_hz = static_cast<double>(spikes) / stimulus.duration_s;
        return response;
    }

    // The probe, on the x axis, for responses from now on.
    void move_probe(double radius_mm, double at_mm) {
        punch_n_ = punch_n(*plan_.patches[0].grid, radius_mm, at_mm);
    }

    // The smallest amplitude of a vibration, of half a second at least, to which it answers at all. It rises
    // and falls over whole cycles, so that the ends of the ramps are no clicks.
    double threshold_um(double frequency_hz) {
        const double cycles_of_ramp = std::ceil(0.05 * frequency_hz);
        const double cycles = std::max(std::ceil(0.5 * frequency_hz), 2 * cycles_of_ramp + 2);
        double silent_mm = 1e-6;
        double heard_mm = 1;
        while (heard_mm / silent_mm > 1.01) {
            const double tried_mm = std::sqrt(silent_mm * heard_mm);
            const Stimulus stimulus{.amplitude_mm = tried_mm,
                                    .frequency_hz = frequency_hz,
                                    .ramp_s = cycles_of_ramp / frequency_hz,
                                    .duration_s = cycles / frequency_hz,
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
    // The wave that reaches an element around the afferent: its force for an indentation of 1 mm.
    struct Wave {
        std::size_t element;
        double delay_s;
        double force_n;
    };
    // As docs/afferents.md has it, at the defaults of a scene's `wave {}`.
    static std::vector<Wave> wave_of(const ElementGrid& grid, double distance_mm, double radius_mm) {
        constexpr double speed_mm_per_s = 8000;
        constexpr double depth_mm = 2.75;
        const double load_n = 2 * radius_mm * contact_modulus;
        const double at_depth = 3 * load_n / (2 * std::numbers::pi * depth_mm * depth_mm);
        std::vector<Wave> wave;
        for (std::uint32_t i = 0; i < grid.elements(); ++i) {
            const auto [x_mm, y_mm] = grid.place(i);
            const double r_mm = std::hypot(x_mm, y_mm);
            if (x_mm < distance_mm - 15 || r_mm <= radius_mm) continue;
            wave.push_back({i, r_mm / speed_mm_per_s,
                            at_depth * 2 / std::numbers::pi * std::asin(radius_mm / r_mm) * grid.pitch_mm() *
                                grid.pitch_mm()});
        }
        return wave;
    }

    static Scene scene_of(scene::Kind kind, double distance_mm, bool conducted,
                          std::optional<scene::Outline> outline) {
        Scene scene;
        scene.patches = {scene::preset(kind)};
        scene::Patch& patch = scene.patches[0];
        patch.name = "skin";
        patch.spread = {};
        patch.outline = scene::Outline{.shape = scene::Rectangle{3, 3}, .pitch_mm = 0.125};
        // A wave is felt under the whole of a field.
        if (distance_mm > 0)
            patch.outline =
                scene::Outline{.shape = scene::Rectangle{2 * distance_mm + 24, 24}, .pitch_mm = 0.5};
        if (outline) patch.outline = std::move(outline);
        patch.afferents->place = {{distance_mm, 0}};
        // 4.9 ms, as in the literature.
        if (conducted) patch.nerve = scene::Nerve{.length_mm = 269.5, .speed_m_per_s = 55};
        scene.source = scene::Pushed();
        scene.record = {.events = true, .force = false, .picture = false};
        return scene;
    }

    bool leaves_skin_;
    Plan plan_;
    Coprocessor coprocessor_;
    std::vector<double> punch_n_;
    std::vector<Wave> wave_;
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
            // The field leaves 1 % out, and the aperture is not quite Gaussian.
            EXPECT_NEAR(OneAfferent(kind, 0, radius_mm).felt_n() / expected_n, 1, 0.03) << radius_mm;
        }
}

void expect_documented(const std::string& rows) {
    std::ifstream in(AFFERENT_SOURCE_DIR "/docs/afferents.md");
    const std::string documented{std::istreambuf_iterator<char>(in), {}};
    EXPECT_NE(documented.find(rows), std::string::npos) << "docs/afferents.md should have\n" << rows;
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
    return name == "SA1" ? scene::Kind::sa1_dynamic : name == "RA" ? scene::Kind::ra : scene::Kind::pc;
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

// How far from the literature a response may be: a spike or a tenth of the rate, and half a millisecond, but
// where what is before the neuron cannot do that.
Response allowance(const Row& row) {
    const Stimulus& s = row.stimulus;
    // A wave that is felt at all makes it fire in nearly each cycle.
    if (s.distance_mm > 0) return {s.frequency_hz, 0.5};
    Response allowed{std::max(1.0, 0.1 * row.literature.rate_hz), 0.5};
    // A slope is known at the sample that ends it, 10 ms later, and a change of slope 1 ms later.
    if (row.kind == "RA" && s.sampling_hz == 100) allowed.first_spike_ms = 5.5;
    if (row.kind == "PC" && s.sampling_hz == 1000) allowed.first_spike_ms = 1.25;
    return allowed;
}

TEST(Literature, ElevenResponsesOfSingleAfferents) {
    const auto file = shared_data() / "afferent_responses.csv";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file << " to compare with";
    const std::vector<Row> rows = rows_of(file);
    ASSERT_EQ(rows.size(), 11U);
    for (const Row& row : rows) {
        OneAfferent afferent(kind_named(row.kind), row.stimulus.distance_mm, row.stimulus.radius_mm,
                             row.conduction == "yes");
        const Response response = afferent.to(row.stimulus);
        const std::string text = table_row(row, response);
        const Response allowed = allowance(row);
        EXPECT_NEAR(response.rate_hz, row.literature.rate_hz, allowed.rate_hz) << text;
        if (std::isfinite(allowed.first_spike_ms)) {
            EXPECT_NEAR(response.first_spike_ms, row.literature.first_spike_ms, allowed.first_spike_ms)
                << text;
        }
        expect_documented(text);
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

// ---- phase locking and entrainment ----

// What a sine drives of one afferent on the axis of a probe of 0.5 mm radius, once it has risen for 50 ms.
// The afferent reads one element that has the force of its whole receptive field.
class VibratedAfferent {
  public:
    explicit VibratedAfferent(scene::Kind kind)
        : felt_n_(OneAfferent(kind, 0, 0.5).felt_n()),
          plan_(make_plan(scene_of(kind))),
          coprocessor_(plan_) {}

    // Spikes in a whole number of cycles, after 0.2 s.
    struct Locking {
        double spikes_per_cycle = 0;
        double vector_strength = 0;  // of the spikes at that frequency
    };
    Locking locking(double amplitude_um, double frequency_hz) {
        constexpr double begin_s = 0.2;
        const double cycles = std::floor(0.35 * frequency_hz);
        double spikes = 0;
        double cosines = 0;
        double sines = 0;
        run(amplitude_um, frequency_hz, begin_s + cycles / frequency_hz, [&](double time_s) {
            if (time_s < begin_s) return true;
            const double phase = 2 * std::numbers::pi * frequency_hz * time_s;
            ++spikes;
            cosines += std::cos(phase);
            sines += std::sin(phase);
            return true;
        });
        return {spikes / cycles, spikes > 0 ? std::hypot(cosines, sines) / spikes : 0};
    }

    bool answers(double amplitude_um, double frequency_hz) {
        bool answered = false;
        run(amplitude_um, frequency_hz, 0.5, [&](double) {
            answered = true;
            return false;
        });
        return answered;
    }

    // The amplitudes from which on it answers at all, fires in each cycle, and fires more often than that:
    // the first I₀, the second I₁ of Talbot et al. (1968), and what lies between the last two is the plateau.
    struct Entrainment {
        double absolute_um;
        double one_per_cycle_um;
        double more_um;          // at most 10 times one_per_cycle_um
        double vector_strength;  // the least of a tenth above the first, of the second and of the plateau's
                                 // middle
    };
    Entrainment entrainment(double frequency_hz) {
        Entrainment found{};
        found.absolute_um = smallest(0.01, 1000, [&](double um) { return answers(um, frequency_hz); });
        found.one_per_cycle_um = smallest(found.absolute_um, 100 * found.absolute_um, [&](double um) {
            return locking(um, frequency_hz).spikes_per_cycle >= 0.95;
        });
        found.more_um = smallest(found.one_per_cycle_um, 10 * found.one_per_cycle_um, [&](double um) {
            return locking(um, frequency_hz).spikes_per_cycle > 1.05;
        });
        found.vector_strength = 1;
        for (const double um : {found.absolute_um * 1.1, found.one_per_cycle_um,
                                std::sqrt(found.one_per_cycle_um * found.more_um)}) {
            const Locking lock = locking(um, frequency_hz);
            if (lock.spikes_per_cycle > 0)
                found.vector_strength = std::min(found.vector_strength, lock.vector_strength);
        }
        return found;
    }

  private:
    // Within 1 %, of a range whose upper end is taken to do.
    template <class Does>
    static double smallest(double below, double enough, Does&& does) {
        while (enough / below > 1.01) {
            const double tried = std::sqrt(below * enough);
            (does(tried) ? enough : below) = tried;
        }
        return enough;
    }

    static Scene scene_of(scene::Kind kind) {
        Scene scene;
        const scene::Patch preset = scene::preset(kind);
        scene.patches = {
            {.name = "ending", .elements = 1, .encoder = preset.encoder, .neuron = preset.neuron}};
        scene.source = scene::Pushed();
        scene.record = {.events = true, .force = false, .picture = false};
        return scene;
    }

    // use(time_s) for each spike, until it returns false.
    template <class Use>
    void run(double amplitude_um, double frequency_hz, double duration_s, Use&& use) {
        coprocessor_.reset();
        const double sampling_hz = std::max(5000.0, 20 * frequency_hz);
        const Stimulus stimulus{.amplitude_mm = amplitude_um / 1000,
                                .frequency_hz = frequency_hz,
                                .duration_s = duration_s + 1,  // it does not fall before the end
                                .sampling_hz = sampling_hz};
        const auto samples = static_cast<std::uint64_t>(duration_s * sampling_hz);
        for (std::uint64_t i = 0; i <= samples; ++i) {
            const TimePoint time = sample_time(i, sampling_hz);
            const double force_n = felt_n_ * stimulus.indentation_mm(seconds(time));
            coprocessor_.push({time, 0, {&force_n, 1}});
            for (const Event& event : coprocessor_.advance(time))
                if (!use(seconds(event.time))) return;
        }
    }

    double felt_n_;
    Plan plan_;
    Coprocessor coprocessor_;
};

// A row of the table, and what it is to be: the frequencies to which the kinds were fitted, and those that
// were kept back.
struct EntrainmentRow {
    scene::Kind kind;
    double frequency_hz;
    bool fitted;
};
constexpr EntrainmentRow entrainment_rows[] = {
    {scene::Kind::ra, 10, false}, {scene::Kind::ra, 20, true},   {scene::Kind::ra, 30, false},
    {scene::Kind::ra, 40, true},  {scene::Kind::ra, 50, false},  {scene::Kind::ra, 60, true},
    {scene::Kind::ra, 80, false}, {scene::Kind::pc, 50, false},  {scene::Kind::pc, 80, false},
    {scene::Kind::pc, 100, true}, {scene::Kind::pc, 150, false}, {scene::Kind::pc, 200, false},
    {scene::Kind::pc, 250, true}, {scene::Kind::pc, 300, false}, {scene::Kind::pc, 400, true},
};

// RA and PC fire at one phase of a vibration, once a cycle over a range of amplitudes: Talbot et al. (1968),
// Freeman and Johnson (1982), Johansson, Landström and Lundström (1982).
TEST(Literature, RaAndPcLockToVibrationOnceACycle) {
    std::map<scene::Kind, VibratedAfferent> afferents;
    for (const EntrainmentRow& row : entrainment_rows) {
        VibratedAfferent& afferent = afferents.try_emplace(row.kind, row.kind).first->second;
        const VibratedAfferent::Entrainment found = afferent.entrainment(row.frequency_hz);
        const double to_one = found.one_per_cycle_um / found.absolute_um;
        const double plateau = found.more_um / found.one_per_cycle_um;
        const int digits = row.kind == scene::Kind::pc ? 2 : 0;
        std::ostringstream text;
        text << "| " << name(row.kind) << " | " << row.frequency_hz << (row.fitted ? "" : ", kept back")
             << " | " << number(found.absolute_um, digits) << " | " << number(found.one_per_cycle_um, digits)
             << " | " << number(to_one, 1) << " | "
             << (plateau > 9.9 ? std::string("over 10") : number(plateau, 1)) << " | "
             << number(found.vector_strength, 2) << " |";
        EXPECT_GE(found.vector_strength, 0.8) << text.str();
        // A half-wave of 10 Hz has more room for a second spike. RA add up several cycles of fast vibration,
        // and PC fire every other cycle of what is faster than they recover from adaptation.
        EXPECT_GE(plateau, row.frequency_hz >= 20 ? 2 : 1.8) << text.str();
        EXPECT_LE(to_one, row.kind == scene::Kind::ra && row.frequency_hz > 50 ? 5 : 3.2) << text.str();
        expect_documented(text.str());
    }
}

// Without the dynamic term the same afferent fires a third as often under a sine, and alike in the hold.
TEST(Literature, Sa1AnswerTheRiseOfPressureAndTheirHoldIsUnchanged) {
    const Stimulus sine{.amplitude_mm = 0.5, .frequency_hz = 10};
    OneAfferent with(scene::Kind::sa1_dynamic, 0, 0.5);
    OneAfferent without(scene::Kind::sa1, 0, 0.5);
    EXPECT_NEAR(with.to(sine).rate_hz, 43, 4.3) << "Saal et al. (2017)";
    EXPECT_LT(without.to(sine).rate_hz, 15);
    for (const double depth_mm : {0.25, 0.5, 1.0, 2.0}) {
        const auto hold_hz = [&](OneAfferent& afferent) {
            // In three seconds of a hold in which what adapts has done so.
            const auto spikes = [&](double duration_s) {
                return afferent
                           .to({.ramp = true,
                                .amplitude_mm = depth_mm,
                                .ramp_s = 1e-3,
                                .duration_s = duration_s,
                                .sampling_hz = 1000})
                           .rate_hz *
                       duration_s;
            };
            return spikes(6) / 3 - spikes(3) / 3;
        };
        // A third of a spike per second, and a twentieth.
        const double old_hz = hold_hz(without);
        EXPECT_NEAR(hold_hz(with), old_hz, 0.34 + 0.05 * old_hz) << depth_mm << " mm";
    }
}

// Johansson and Vallbo (1979): 9.2 µm, 13.8 µm and 56.5 µm in the median. Each kind at its best frequency,
// SA1 at the slowest that fits.
TEST(Literature, ThresholdsRiseFromPcOverRaToSa1) {
    const double pc_um = OneAfferent(scene::Kind::pc, 0, 0.5).threshold_um(250);
    const double ra_um = OneAfferent(scene::Kind::ra, 0, 0.5).threshold_um(45);
    const double sa1_um = OneAfferent(scene::Kind::sa1_dynamic, 0, 0.5).threshold_um(5);
    EXPECT_LT(pc_um, ra_um);
    EXPECT_LT(ra_um, sa1_um);
    EXPECT_NEAR(std::log(ra_um / 13.8), 0, std::log(2)) << "the same within 6 dB";
    EXPECT_NEAR(std::log(sa1_um / 56.5), 0, std::log(1.5));
    expect_documented("PC " + number(pc_um, 2) + " µm at 250 Hz, RA " + number(ra_um, 0) +
                      " µm at 45 Hz, SA1 " + number(sa1_um, 0) + " µm");
}

// Beside the table of Ouyang, Wu, Shao, Wu and Cao (2019), Front Neuroinform 13:27, between whose frequencies
// lines are drawn on logarithmic scales. It is of earlier recordings and does not say their probes: where it
// is lower for all of a kind, that may be the probe.
TEST(Literature, ThresholdsOfVibrationsAgainstTheirFrequency) {
    if (!long_runs) GTEST_SKIP() << "it takes minutes with sanitizers";
    constexpr std::array frequencies_hz{1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0};
    struct Curve {
        scene::Kind kind;
        const char* name;
        std::array<double, frequencies_hz.size()> published_um;  // 0: none
        double lowest_db, highest_db;                            // above the published
    };
    for (const auto& [kind, name, published_um, lowest_db, highest_db] :
         {Curve{scene::Kind::sa1_dynamic, "SA1", {0, 27, 21, 25, 32, 42, 0, 0, 0}, -8, 10},
          Curve{scene::Kind::ra, "RA", {0, 26, 11, 5.6, 1.8, 1.3, 0, 0, 0}, 10, 27},
          Curve{scene::Kind::pc, "PC", {0, 0, 0, 33, 3.9, 0.30, 0.077, 0.042, 0}, -4, 12}}) {
        OneAfferent afferent(kind, 0, 0.5);
        std::string here = std::string("| ") + name + " |";
        std::string published = here.substr(0, here.size() - 2) + ", published |";
        for (std::size_t i = 0; i < frequencies_hz.size(); ++i) {
            const double um = afferent.threshold_um(frequencies_hz[i]);
            here += um < 990 ? " " + number(um, um < 10 ? 2 : 0) + " |" : " over 1000 |";
            const double other_um = published_um[i];
            published += other_um > 0
                             ? " " + number(other_um, other_um < 10 ? other_um < 0.1 ? 3 : 1 : 0) + " |"
                             : " |";
            if (!(other_um > 0)) continue;
            const double above_db = 20 * std::log10(um / other_um);
            EXPECT_GT(above_db, lowest_db) << name << " at " << frequencies_hz[i] << " Hz";
            EXPECT_LT(above_db, highest_db) << name << " at " << frequencies_hz[i] << " Hz";
        }
        expect_documented(here + "\n" + published + "\n");
    }
}

// A probe that is pressed on for 0.2 s, in the middle of a field for the spikes. A field is a disc.
TEST(Literature, FieldsAndSpikesAgainstDepth) {
    std::string rows;
    for (const auto& [kind, name] :
         {std::pair(scene::Kind::sa1_dynamic, "SA1"), std::pair(scene::Kind::ra, "RA")}) {
        OneAfferent afferent(kind, 0, 0.5, false,
                             scene::Outline{.shape = scene::Rectangle{9, 9}, .pitch_mm = 0.25});
        std::string areas = std::string("| ") + name + ", field, mm² |";
        std::string counts = std::string("| ") + name + ", spikes |";
        for (const double depth_mm : {0.1, 0.2, 0.3, 0.5, 1.0}) {
            const auto spikes = [&](double away_mm) {
                afferent.move_probe(0.5, away_mm);
                const Stimulus press{.ramp = true,
                                     .amplitude_mm = depth_mm,
                                     .ramp_s = 0.01,
                                     .duration_s = 0.2,
                                     .sampling_hz = 2000};
                return afferent.to(press).rate_hz * press.duration_s;
            };
            double felt_mm = 0;
            double silent_mm = 4;
            while (silent_mm - felt_mm > 0.01) {
                const double tried_mm = (felt_mm + silent_mm) / 2;
                (spikes(tried_mm) > 0 ? felt_mm : silent_mm) = tried_mm;
            }
            areas += " " + number(std::numbers::pi * felt_mm * felt_mm, 1) + " |";
            counts += " " + number(spikes(0), 0) + " |";
        }
        rows += areas + "\n" + counts + "\n";
    }
    expect_documented(rows);
}

}  // namespace
}  // namespace afferent
