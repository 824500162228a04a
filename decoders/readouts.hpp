// All read-outs of a controller. A kind of read-out is one line in each of the two lists here.
#pragma once

#include <algorithm>
#include <span>
#include <variant>
#include <vector>

#include "afferent/decoders/contact.hpp"
#include "afferent/decoders/edge.hpp"
#include "afferent/decoders/readout.hpp"
#include "afferent/decoders/texture.hpp"

namespace afferent {

using ReadoutParameters =
    std::variant<ContactReadout::Parameters, EdgeReadout::Parameters, TextureReadout::Parameters>;

// Allocates nothing after construction.
class Readouts {
  public:
    using Any = std::variant<ContactReadout, EdgeReadout, TextureReadout>;
    using AnySnapshot =
        std::variant<ContactReadout::Snapshot, EdgeReadout::Snapshot, TextureReadout::Snapshot>;
    using Snapshot = std::vector<AnySnapshot>;

    // Throws ParameterError.
    explicit Readouts(const std::vector<ReadoutParameters>& parameters);

    // As of a decoder (decoder.hpp).
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events);
    void lose(TimePoint begin, TimePoint end);
    void presume_silence(TimePoint until);
    void restart(TimePoint start);
    // The last step was at `start`.
    void resume_after(TimePoint start, TimePoint heard_until);
    Duration history() const;
    Snapshot snapshot() const;
    // Throws ParameterError where the snapshot is of other read-outs.
    void resume(const Snapshot& snapshot);
    std::size_t bytes() const;
    // How many patches have that kind.
    template <class Kind>
    std::size_t count() const {
        return static_cast<std::size_t>(std::ranges::count_if(
            readouts_, [](const Any& each) { return std::holds_alternative<Kind>(each); }));
    }

    // Replaces `told` by what there is to tell: at most `most_told` of each read-out. Times of steps do not
    // decrease.
    static constexpr std::size_t most_told = ContactReadout::most_contacts;
    void step(TimePoint now, std::vector<PatchReadout>& told);

  private:
    std::vector<Any> readouts_;
};

}  // namespace afferent
