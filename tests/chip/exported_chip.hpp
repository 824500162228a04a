// A chip of a test, exported to a folder, and what is said of it there.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "afferent/chip/chip_neurons.hpp"
#include "afferent/chip/exported_file.hpp"
#include "afferent/chip/vectors.hpp"
#include "tests/temporary_folder.hpp"

namespace afferent {

inline bool is_there(const std::string& program) {
    return std::system(("command -v " + program + " >/dev/null").c_str()) == 0;
}

#define SKIP_WITHOUT(program) \
    if (!is_there(program))   \
    GTEST_SKIP() << program << " is not installed: scripts/install-dependencies.sh chip"

// Two neurons of a patch for each text of a fixed_point {}.
inline ChipNeurons chip_of(const std::vector<std::string>& fixed_points,
                           const std::string& neuron = "delta_g: 0.03", int elements = 2) {
    std::string text = "duration_s: 1 source { profile { point { time_s: 0 force_n: 0 } } }";
    for (std::size_t i = 0; i < fixed_points.size(); ++i) {
        text += " patch { name: \"" + std::to_string(i) + "\" elements: " + std::to_string(elements);
        for (int element = 0; element < elements; ++element) text += " share: 0.001";
        text +=
            " neuron { " + neuron + " tau_m_ms: 10 tau_g_ms: 500 fixed_point { " + fixed_points[i] + " } } }";
    }
    return chip_neurons(make_plan(Scene::from_text(text)));
}

// The widths that the tests go through; each with both roundings.
inline const char* const widths_of_chips[] = {
    "tick_us: 1000 state_bits: 8 decay_bits: 12",  "tick_us: 1000 state_bits: 12 decay_bits: 12",
    "tick_us: 1000 state_bits: 16 decay_bits: 16", "tick_us: 100 state_bits: 16 decay_bits: 24",
    "tick_us: 1000 state_bits: 24 decay_bits: 24", "tick_us: 100 state_bits: 32 decay_bits: 24"};

// Three groups of constants in one chip.
inline ChipNeurons chip_of_several_widths() {
    return chip_of({"tick_us: 1000 state_bits: 8 decay_bits: 12", "tick_us: 1000 state_bits: 16",
                    "tick_us: 1000 state_bits: 32 decay_bits: 24 rounding: TRUNCATION"});
}

// u of 17 bits, since v_r lies below E_k, and a refractory period.
inline ChipNeurons chip_below_e_k(const std::string& delta_g) {
    return chip_of({"tick_us: 1000"},
                   "refractory_ms: 2 e_k_mv: -69 v_r_mv: -70 v_th_mv: -55 delta_g: " + delta_g);
}

// What a text of the exported arithmetic becomes, so that it is wrong.
struct Change {
    const char* from;
    const char* to;
};

class ExportedChip {
  public:
    ExportedChip(const ChipNeurons& neurons, const ChipParts& parts, std::vector<ExportedFile> files,
                 const VectorLength& length)
        : files_(std::move(files)) {
        std::ofstream out(folder_ / "vectors.txt");
        write(chip_vectors(neurons, parts, 1, length), neurons.count(), out);
    }

    std::string& file(const std::string& name) {
        return std::ranges::find(files_, name, &ExportedFile::name)->text;
    }

    void make(const Change& change, const std::string& name) {
        std::string& text = file(name);
        const std::size_t at = text.find(change.from);
        if (at == std::string::npos) throw std::invalid_argument(name + " has no " + change.from);
        text.replace(at, std::string(change.from).size(), change.to);
    }

    // Makes the change, runs the check and undoes the change; returns what the check says.
    template <class Check>
    std::string once_changed(const Change& change, const std::string& name, const Check& check) {
        const std::vector<ExportedFile> unchanged = files_;
        make(change, name);
        const std::string said = check(*this);
        files_ = unchanged;
        return said;
    }

    // Runs a command there. Empty: it succeeded; otherwise what it said.
    std::string failure_of(const std::string& command) {
        for (const ExportedFile& file : files_) std::ofstream(folder_ / file.name) << file.text;
        const bool succeeded =
            std::system(("cd '" + folder_("") + "' && (" + command + ") >all_said 2>&1").c_str()) == 0;
        return succeeded ? "" : "said: " + said();
    }

    std::string said() const {
        std::ifstream file(folder_ / "all_said");
        return {std::istreambuf_iterator<char>(file), {}};
    }

  private:
    Folder folder_;
    std::vector<ExportedFile> files_;
};

}  // namespace afferent
