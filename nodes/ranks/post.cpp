#include "afferent/nodes/ranks/post.hpp"

#include <mpi.h>

#include <algorithm>
#include <utility>

namespace afferent::ranks {

std::optional<Kind> receive(std::size_t from, Bytes& bytes) {
    int found = 0;
    MPI_Message message{};
    MPI_Status status{};
    MPI_Improbe(static_cast<int>(from), MPI_ANY_TAG, MPI_COMM_WORLD, &found, &message, &status);
    if (found == 0) return std::nullopt;
    int count = 0;
    MPI_Get_count(&status, MPI_BYTE, &count);
    bytes.resize(static_cast<std::size_t>(count));
    const auto kind = static_cast<Kind>(status.MPI_TAG);
    MPI_Mrecv(bytes.data(), count, MPI_BYTE, &message, MPI_STATUS_IGNORE);
    return kind;
}

struct Outbox::Sending {
    std::shared_ptr<const Bytes> bytes;
    MPI_Request request;
};

Outbox::Outbox(std::size_t to) : to_(to) {}
Outbox::~Outbox() = default;
Outbox::Outbox(Outbox&&) noexcept = default;
Outbox& Outbox::operator=(Outbox&&) noexcept = default;

// Synchronous: it is done when the other begins to receive, so that what is on its way stays bounded.
void Outbox::send(Kind kind, std::shared_ptr<const Bytes> bytes) {
    MPI_Request request{};
    MPI_Issend(bytes->data(), static_cast<int>(bytes->size()), MPI_BYTE, static_cast<int>(to_),
               static_cast<int>(kind), MPI_COMM_WORLD, &request);
    sending_.push_back({std::move(bytes), request});
}

std::size_t Outbox::waiting() {
    const auto is_done = [](Sending& sending) {
        int done = 0;
        MPI_Test(&sending.request, &done, MPI_STATUS_IGNORE);
        return done != 0;
    };
    const auto first = std::find_if_not(sending_.begin(), sending_.end(), is_done);
    sending_.erase(sending_.begin(), first);
    return sending_.size();
}

std::shared_ptr<Bytes> Buffers::next() {
    const auto unused =
        std::find_if(all_.begin(), all_.end(), [](const auto& bytes) { return bytes.use_count() == 1; });
    if (unused == all_.end()) return all_.emplace_back(std::make_shared<Bytes>());
    (*unused)->clear();
    return *unused;
}

}  // namespace afferent::ranks
