// The processes of an MPI job, numbered from 0: its ranks.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace afferent::ranks {

// One object in a program; all of MPI happens on the thread that made it. Where a rank dies, the MPI library
// ends the others.
class World {
  public:
    World(int& argc, char**& argv);
    // Waits for the other ranks to come as far, unless they are given up.
    ~World();
    World(const World&) = delete;
    World& operator=(const World&) = delete;

    std::size_t rank() const noexcept { return rank_; }
    std::size_t size() const noexcept { return size_; }
    bool is_first() const noexcept { return rank_ == 0; }
    // How many of this machine's ranks there are: they share its processors.
    std::size_t neighbours() const noexcept { return neighbours_; }

    // To be called by all ranks, in the same order; they wait for each other.
    // Rank 0 gets what each gives, in their order; the others get nothing.
    std::vector<std::string> gather(const std::string& bytes);
    // All get what rank 0 gives.
    std::string broadcast(const std::string& bytes);

    // A rank has died or hangs: nobody is waited for any more, and the object's end is that of the job.
    void give_up(int exit_code) noexcept { given_up_ = exit_code; }

  private:
    std::size_t rank_;
    std::size_t size_;
    std::size_t neighbours_;
    int given_up_ = 0;
};

}  // namespace afferent::ranks
