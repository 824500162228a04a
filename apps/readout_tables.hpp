// Writes what is read out of the patches: a table for each kind of read-out, and a line of the summary for
// each patch.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "afferent/apps/summary.hpp"
#include "afferent/decoders/readouts.hpp"
#include "afferent/engine/controller.hpp"
#include "afferent/io/files/table_writer.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

class ReadoutTables {
  public:
    // Nothing to write, or to sum up, where the plan has no read-outs.
    explicit ReadoutTables(const Plan& plan);

    // What the tables of all kinds are called.
    static std::vector<std::string> names();
    // Opens the tables that there are.
    void open(const std::filesystem::path& folder, FullPipe full_pipe);
    void step(const ControllerStep& step);
    void add_to(Summary& summary) const;

    // Null where a table is not written.
    std::vector<std::optional<TableWriter>*> writers();
    bool failed() const;

  private:
    template <class Kind>
    struct Table {
        std::map<std::uint32_t, typename Kind::Totals> totals;  // by patch, of those that have it
        std::optional<TableWriter> writer;
    };
    template <class AnyKind>
    struct TablesOf;
    template <class... Kinds>
    struct TablesOf<std::variant<Kinds...>> {
        std::tuple<Table<Kinds>...> all;
    };

    const Plan& plan_;
    TablesOf<Readouts::Any> tables_;
};

}  // namespace afferent
