#include "afferent/nodes/ranks/world.hpp"

#include <mpi.h>

#include <numeric>

namespace afferent::ranks {
namespace {

int to_int(std::size_t value) { return static_cast<int>(value); }

}  // namespace

World::World(int& argc, char**& argv) {
    int provided = 0;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
    int rank = 0;
    int size = 1;
    int neighbours = 1;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    MPI_Comm machine{};
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank, MPI_INFO_NULL, &machine);
    MPI_Comm_size(machine, &neighbours);
    MPI_Comm_free(&machine);
    rank_ = static_cast<std::size_t>(rank);
    size_ = static_cast<std::size_t>(size);
    neighbours_ = static_cast<std::size_t>(neighbours);
}

World::~World() {
    if (given_up_ != 0) MPI_Abort(MPI_COMM_WORLD, given_up_);
    MPI_Finalize();
}

std::vector<std::string> World::gather(const std::string& bytes) {
    const int length = to_int(bytes.size());
    std::vector<int> lengths(is_first() ? size_ : 0);
    MPI_Gather(&length, 1, MPI_INT, lengths.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
    std::vector<int> begins(lengths.size());
    if (is_first()) std::exclusive_scan(lengths.begin(), lengths.end(), begins.begin(), 0);
    std::string all;
    if (is_first())
        all.resize(static_cast<std::size_t>(begins.back()) + static_cast<std::size_t>(lengths.back()));
    MPI_Gatherv(bytes.data(), length, MPI_BYTE, all.data(), lengths.data(), begins.data(), MPI_BYTE, 0,
                MPI_COMM_WORLD);
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < lengths.size(); ++i)
        parts.push_back(
            all.substr(static_cast<std::size_t>(begins[i]), static_cast<std::size_t>(lengths[i])));
    return parts;
}

std::string World::broadcast(const std::string& bytes) {
    int length = to_int(bytes.size());
    MPI_Bcast(&length, 1, MPI_INT, 0, MPI_COMM_WORLD);
    std::string all = bytes;
    all.resize(static_cast<std::size_t>(length));
    MPI_Bcast(all.data(), length, MPI_BYTE, 0, MPI_COMM_WORLD);
    return all;
}

}  // namespace afferent::ranks
