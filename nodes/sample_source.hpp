// Where a scene's samples come from.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "afferent/io/files/table_reader.hpp"
#include "afferent/io/wire/result.hpp"
#include "afferent/nodes/patch_sensors.hpp"
#include "afferent/runtime/event_queue.hpp"
#include "afferent/runtime/scan.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

class SampleSource {
  public:
    // The plan outlives it.
    explicit SampleSource(const Plan& plan);
    virtual ~SampleSource() = default;

    // When the next scan is due, and of which patch; nothing if there are no more.
    virtual std::optional<Due> next() = 0;
    // That scan, valid until the next call; nothing if it is refused, and then there are no others.
    // `hand_force_n` is the grip force of a simulated hand at that time. Allocates nothing.
    virtual std::optional<Scan> take(double hand_force_n) = 0;
    // Why it was refused.
    virtual Error refusal() const { return {Error::Kind::malformed, ""}; }
    // Reads all that a file has to tell, so that nothing above waits for it.
    virtual Result<void> read_all() { return success(); }
    // The grip force behind the samples, where it is known.
    virtual std::optional<double> true_force_n(TimePoint time) const = 0;

    std::uint64_t samples() const noexcept;
    std::uint64_t clipped() const noexcept;

  protected:
    PatchSensors& sensors(std::size_t patch) noexcept { return sensors_[index_[patch]]; }
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
    std::optional<double> true_force_n(TimePoint time) const override;

  private:
    EventQueue queue_;
    std::vector<std::uint64_t> taken_;  // scans of each patch
    struct Refused {
        Due due;
        double grip_n;
    };
    Refused refused_{};
};

// A table: from a file, from standard input, or as a program feeds its bytes.
class TableSource final : public SampleSource {
  public:
    // Fills the buffer and returns how much; 0 at the end.
    using Read = std::function<std::size_t(std::span<char> buffer)>;

    // The name begins every message. With `read`, more is read whenever there is no row left; without it,
    // there are the rows that have been fed.
    TableSource(const Plan& plan, std::string name, std::vector<std::string> columns,
                bool refuse_out_of_range, Read read = {});

    // Opens the table of a scene.
    static Result<std::unique_ptr<TableSource>> open(const Plan& plan, const scene::Table& table);

    Result<void> feed(std::string_view bytes);
    Result<void> finish();
    bool is_fed() const noexcept { return !read_; }
    // No row is left, and more may come.
    bool starving() const noexcept { return rows_.empty() && !ended_; }

    std::optional<Due> next() override;
    std::optional<Scan> take(double hand_force_n) override;
    Error refusal() const override;
    Result<void> read_all() override;
    std::optional<double> true_force_n(TimePoint) const override { return grip_force_n_; }
    // What went wrong while reading ahead; next() then has no more rows.
    const std::optional<Error>& error() const noexcept { return error_; }

  private:
    struct Row {
        TimePoint time;
        std::size_t line;
        std::vector<double> values;
    };
    enum class Columns { unknown, grip_n, elements_n, elements_counts };

    void read_once();
    void read_ahead();
    Result<void> understand_columns();
    // The first value of the first row that is out of range, where such are refused.
    struct Refused {
        const PatchPlan* patch;
        double value;
    };
    std::optional<Refused> out_of_range(const Row& row) const;

    TableReader reader_;
    std::string name_;
    bool refuse_out_of_range_;
    Read read_;
    std::vector<char> buffer_;
    Columns columns_ = Columns::unknown;
    std::deque<Row> rows_;        // still to be taken
    std::size_t next_owner_ = 0;  // who takes the first of them next
    bool ended_ = false;
    std::optional<double> grip_force_n_;
    std::optional<Error> error_;
};

}  // namespace afferent
