// Collects what the picture of the read-outs shows, as a run goes on.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "afferent/decoders/readouts.hpp"
#include "afferent/engine/controller.hpp"
#include "afferent/io/pictures/panel_grid.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// A row of panels for each kind of read-out: every column of its table that has a sigma, over time, with two
// sigmas on each side; a curve for each patch. Memory is bounded: of a long run it shows every second
// read-out, or every fourth, and so on.
class ReadoutPicture {
  public:
    // The plan outlives it.
    explicit ReadoutPicture(const Plan& plan) : plan_(plan) {}

    void step(const ControllerStep& step);

    bool is_empty() const noexcept;
    // <stem>.svg and <stem>.png.
    Drawing draw(const std::filesystem::path& stem) const;

  private:
    // Unknown values are NaN.
    struct Column {
        std::vector<double> values, sigmas;
    };
    // A patch has one in each panel, and another one where it has had two contacts.
    struct Curve {
        std::vector<double> times_s;
        std::map<std::string, Column> columns;
        std::uint64_t every = 1;  // of the read-outs is kept
        std::uint64_t seen = 0;
        double last_s = 0, before_s = 0;  // of the last read-out, and of the one before

        void keep(double time_s, const std::vector<std::pair<std::string, double>>& numbers);
    };
    struct Kind {
        std::vector<std::string> columns;  // that have a sigma, in the table's order
        std::map<std::pair<std::uint32_t, std::uint64_t>, Curve> curves;
    };

    template <class Row>
    void add(const Row& row, Kind& kind);
    std::string name_of(std::uint32_t patch, std::uint64_t contact) const;
    std::vector<PanelGrid::Panel> panels_of(const Kind& kind, double end_s) const;

    const Plan& plan_;
    std::array<Kind, std::variant_size_v<PatchReadout>> kinds_;  // in the order of PatchReadout
};

}  // namespace afferent
