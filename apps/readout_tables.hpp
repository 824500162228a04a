// Writes what is read out of the patches: contact.csv and touches.csv, and a line of the summary for each
// patch.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "afferent/apps/summary.hpp"
#include "afferent/engine/controller.hpp"
#include "afferent/io/files/table_writer.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

class ReadoutTables {
  public:
    // Nothing to write, or to sum up, where the plan has no read-outs.
    explicit ReadoutTables(const Plan& plan);

    // Opens the tables that there are.
    void open(const std::filesystem::path& folder, FullPipe full_pipe);
    void step(const ControllerStep& step);
    void add_to(Summary& summary) const;

    // Null where a table is not written.
    std::array<std::optional<TableWriter>*, 2> writers() noexcept { return {&contact_, &touches_}; }
    bool failed() const noexcept {
        return (contact_ && contact_->error()) || (touches_ && touches_->error());
    }

  private:
    struct OfPatch {
        std::uint32_t patch;
        double largest_force_n = 0;
        std::uint64_t touches = 0;
        std::optional<EdgeTouch> last{};
    };
    OfPatch& of(std::vector<OfPatch>& patches, std::uint32_t patch) const;
    void write(const PatchContact& contact, TimePoint time);
    void write(const EdgeTouch& touch);

    const Plan& plan_;
    std::vector<OfPatch> contacts_of_;
    std::vector<OfPatch> touches_of_;
    std::optional<TableWriter> contact_;
    std::optional<TableWriter> touches_;
};

}  // namespace afferent
