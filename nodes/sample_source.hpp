// Where a scene's samples come from.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "afferent/encoders/receptive_fields.hpp"
#include "afferent/engine/controller.hpp"
#include "afferent/io/files/scan_set.hpp"
#include "afferent/io/files/table_input.hpp"
#include "afferent/io/files/table_reader.hpp"
#include "afferent/nodes/patch_sensors.hpp"
#include "afferent/runtime/event_queue.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/runtime/scan.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// Gives the parts of a step their shares of its true grip force, where that is known.
void tell_shares(const Plan& plan, ControllerStep& step);

class SampleSource {
  public:
    // The plan outlives it.
    explicit SampleSource(const Plan& plan);
    virtual ~SampleSource() = default;

    // When the next scan is due, and of which patch; nothing if there are no more.
    virtual std::optional<Due> next() = 0;
    // The scan that is due, valid until the next call; nothing if it is refused, and then no others follow.
    // `hand_force_n` is the grip force of a simulated hand at that time. Allocates nothing.
    virtual std::optional<Scan> take(double hand_force_n) = 0;
    // Why a scan was refused.
    virtual Error refusal() const { return {Error::Kind::malformed, ""}; }
    // What people should know of where the samples came from.
    virtual std::vector<std::string> said() const { return {}; }
    // Reads a file to its end, so that nothing waits for it later.
    virtual Result<void> read_all() { return success(); }
    // The grip force behind the samples, where it is known.
    virtual std::optional<double> true_force_n(TimePoint time) const {
        return stated_grip_n(plan_.scene.source, time);
    }
    // Gives the parts of a step their true forces: their shares of that of the grip, where it is known.
    virtual void tell_true_forces(ControllerStep& step) const;

    std::uint64_t samples() const noexcept;
    std::uint64_t clipped() const noexcept;
    // What people should know where most samples that are not 0 were clipped; else empty.
    std::string said_of_clipped() const;

  protected:
    PatchSensors& sensors(std::size_t patch) noexcept { return sensors_[index_[patch]]; }
    const PatchSensors& sensors(std::size_t patch) const noexcept { return sensors_[index_[patch]]; }
    // The indices of the patches that own elements.
    const std::vector<std::size_t>& owners() const noexcept { return owners_; }
    const Plan& plan() const noexcept { return plan_; }

  private:
    const Plan& plan_;
    std::vector<std::size_t> owners_;
    std::vector<std::size_t> index_;
    std::vector<PatchSensors> sensors_;
};

// A grip force, felt by each patch at its own sampling rate: the simulated hand's, or the scene's profile.
class ClockedSource final : public SampleSource {
  public:
    explicit ClockedSource(const Plan& plan);
    std::optional<Due> next() override { return queue_.next(); }
    std::optional<Scan> take(double hand_force_n) override;
    Error refusal() const override;

  private:
    EventQueue queue_;
    std::vector<std::uint64_t> taken_;  // scans of each patch
    struct Refused {
        Due due;
        double grip_n;
    };
    Refused refused_{};
};

// A table: from a file, from standard input, or as a program feeds its bytes; or scans recorded in HDF5.
class TableSource final : public SampleSource {
  public:
    // Fills the buffer and returns how many bytes; 0 at the end.
    using Read = std::function<std::size_t(std::span<char> buffer)>;

    // The table's path begins every message; nothing is opened. With `read`, more is read whenever no row is
    // left; without it, rows come from feed().
    TableSource(const Plan& plan, scene::Table table, Read read = {});
    // A value for each element; or the grip force alone; or an image that is laid over all outlines on the
    // map: each element feels the part of every pixel's force that is on its cell.
    static Result<std::unique_ptr<TableSource>> of_scans(const Plan& plan, scene::Table table, ScanSet scans);

    // Opens the table of a scene.
    static Result<std::unique_ptr<TableSource>> open(const Plan& plan, const scene::Table& table);

    Result<void> feed(std::string_view bytes);
    Result<void> finish();
    bool is_fed() const noexcept { return !read_ && !file_ && !scans_; }
    // No row is left, and more may come.
    bool starving() const noexcept { return rows_.empty() && !ended_; }

    std::optional<Due> next() override;
    std::optional<Scan> take(double hand_force_n) override;
    Error refusal() const override;
    // Up to 256 MiB of rows; those behind are read as they are needed.
    Result<void> read_all() override;
    std::vector<std::string> said() const override;
    // Between two rows the force lies on the straight line, or is that of the row before, as the scene says.
    std::optional<double> true_force_n(TimePoint time) const override;
    // With a column for each element, the parts' true forces are taken from these columns and not from
    // shares.
    void tell_true_forces(ControllerStep& step) const override;
    // What the table is taken for, by what has been read of it.
    TableFormat format() const;
    // The time of the last row, once all have been taken.
    std::optional<TimePoint> end() const;
    // What went wrong while reading ahead; next() then has no more rows.
    const std::optional<Error>& error() const noexcept { return error_; }

  private:
    struct Row {
        TimePoint time;
        std::size_t line;
        std::vector<double> values;
        double grip_force_n = 0;
    };
    enum class Columns { unknown, grip_n, elements_n, elements_counts };

    Result<std::size_t> fill_buffer();
    void read_once();
    void read_scan();
    void read_ahead();
    Result<void> understand_scans();
    Result<void> understand_columns();
    // The first value of the first row that is out of range, where such are refused.
    struct Refused {
        const PatchPlan* patch;
        double value;
    };
    std::optional<Refused> out_of_range(const Row& row) const;
    double grip_force_n(const std::vector<double>& values) const;
    // A force at that time, which is `before` at the row taken last and `after` at the next.
    double between(TimePoint time, double before, double after) const;
    // Lets every patch sample the stretch up to the first row.
    void begin_row();
    std::int64_t steps_to_row(std::size_t patch) const noexcept;
    // The values of the columns at that time, which lies on the stretch up to the first row.
    std::span<const double> values(TimePoint time);

    scene::Table table_;
    TableReader reader_;
    Read read_;
    std::optional<TableInput> file_;
    std::vector<char> buffer_;
    std::optional<ScanSet> scans_;
    std::size_t next_scan_ = 0;
    std::optional<ReceptiveFields> image_;  // what each element feels of an image's pixels
    std::vector<double> pixels_;
    Columns columns_ = Columns::unknown;
    std::vector<double> factors_;  // of the columns; empty: all 1
    // The rows still to be taken. While there are any, the patches sample the stretch up to the first.
    std::deque<Row> rows_;
    std::optional<Row> before_;  // the row taken last
    EventQueue queue_;
    std::vector<std::int64_t> taken_;  // steps of each patch to the first row
    std::vector<double> values_;       // between two rows
    bool checked_ = false;             // the first row is within range
    bool ended_ = false;
    std::optional<Error> error_;
};

}  // namespace afferent
