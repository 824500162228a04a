// Writes what a run computes: events.csv, afferents.csv, force.csv, emg.csv, contact.csv, touches.csv,
// texture.csv, summary.json and the pictures.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/apps/population_view.hpp"
#include "afferent/apps/readout_picture.hpp"
#include "afferent/apps/readout_tables.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/io/files/results_folder.hpp"
#include "afferent/io/files/table_writer.hpp"
#include "afferent/io/pictures/grasp_picture.hpp"
#include "afferent/nodes/doubt_times.hpp"
#include "afferent/nodes/force_error.hpp"
#include "afferent/nodes/hand_end.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

class Recorder {
  public:
    // Which of the two ends are recorded.
    struct Ends {
        bool coprocessor;
        bool hand;
    };

    // Makes the folder, which close() fills. An empty name: nothing is written, and only the force error is
    // kept. Throws Failure.
    Recorder(const Plan& plan, const std::filesystem::path& folder, Ends link_ends,
             FullPipe full_pipe = FullPipe::wait);

    void events(std::span<const Event> events);
    // What presses the skin, for the picture of it; need not be told.
    void scan(const Scan& scan) {
        if (view_) view_->scan(scan);
    }
    void step(const ControllerStep& step);
    // Where the scene was broken off, if it was.
    void broken_off(TimePoint at) { end_ = at; }
    const ForceError& error() const noexcept { return error_; }
    // Adds the error of each part, and what has been read out, where the scene asks for them.
    void add_readouts(Summary& summary) const;
    // Whether a table can no longer be written: close() will say why. Nothing more is written to it.
    bool failed() const noexcept;
    // How many steps were not written for that reason, or because a pipe was full; final once the tables are
    // closed.
    std::uint64_t unwritten_steps() const noexcept;

    // Throws Failure for the first table that could not be written; close() throws for one that goes into a
    // pipe.
    void close_tables();
    // Closes the tables if they are open, writes the summary, and puts all of it in place of an earlier
    // run's. Throws Failure; then the earlier files are still there, and those that an end of a link has
    // written stay beside them.
    void close(const Summary& summary);
    // Draws the pictures that there are: gnuplot takes a second. Returns why one could not be drawn.
    std::optional<std::string> draw_pictures();
    // close() and draw_pictures().
    std::optional<std::string> finish(const Summary& summary) {
        close(summary);
        return draw_pictures();
    }

  private:
    // All tables: those that are not written are empty.
    std::vector<std::optional<TableWriter>*> tables();
    void write_if_known(std::optional<double> force_n);
    void keep_for_picture(const ControllerStep& step);
    std::string kept_unfinished();
    std::optional<std::string> put_in_place(const Drawing& drawing, const std::string& stem);

    const Plan& plan_;
    std::optional<ResultsFolder> results_;
    bool repeatable_;
    std::uint64_t unwritten_steps_ = 0;
    bool tables_are_closed_ = false;
    std::optional<TableError> pipe_error_;
    ForceError error_;
    DoubtTimes doubts_;
    std::vector<ForceError> part_errors_;
    std::optional<TableWriter> events_;
    std::optional<TableWriter> force_;
    std::optional<TableWriter> emg_;
    ReadoutTables readouts_;
    bool draws_;
    std::uint64_t steps_ = 0;
    std::uint64_t step_stride_ = 1;  // of those drawn
    GraspPicture picture_;
    ReadoutPicture readout_picture_;
    std::optional<PopulationView> view_;  // where afferents have places
    TimePoint end_;
};

// The folder of a process's n-th recorder, counted from 1: an end that starts over after a broken session
// does not overwrite what it wrote before.
std::filesystem::path session_folder(const std::filesystem::path& out, int n);

}  // namespace afferent
