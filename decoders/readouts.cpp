#include "afferent/decoders/readouts.hpp"

#include <algorithm>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

Readouts::Readouts(const Parameters& parameters) : interval_(parameters.interval) {
    require(parameters.contacts.empty() || interval_ > 0ns, "interval", "> 0", seconds(interval_));
    contacts_.reserve(parameters.contacts.size());
    for (const auto& [patch, contact] : parameters.contacts) {
        contacts_.emplace_back(contact);
        estimates_.push_back({patch, {}});
    }
    edges_.reserve(parameters.edges.size());
    for (const EdgeReadout::Parameters& edge : parameters.edges) edges_.emplace_back(edge);
    touches_.reserve(edges_.size());
}

void Readouts::observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
    for (ContactReadout& contact : contacts_) contact.observe(begin, end, events);
    for (EdgeReadout& edge : edges_) edge.observe(begin, end, events);
}

void Readouts::lose(TimePoint begin, TimePoint end) {
    for (ContactReadout& contact : contacts_) contact.lose(begin, end);
    for (EdgeReadout& edge : edges_) edge.lose(begin, end);
}

void Readouts::presume_silence(TimePoint until) {
    for (ContactReadout& contact : contacts_) contact.presume_silence(until);
}

void Readouts::restart(TimePoint start) {
    for (ContactReadout& contact : contacts_) contact.restart(start);
    for (EdgeReadout& edge : edges_) edge.restart(start);
}

void Readouts::resume_after(TimePoint start, TimePoint heard_until) {
    for (ContactReadout& contact : contacts_) contact.resume_after(start, heard_until);
    for (EdgeReadout& edge : edges_) edge.restart(start);
    if (!contacts_.empty()) intervals_ = intervals_until(start);
}

Duration Readouts::history() const {
    Duration longest{};
    for (const ContactReadout& contact : contacts_) longest = std::max(longest, contact.history());
    for (const EdgeReadout& edge : edges_) longest = std::max(longest, edge.history());
    return longest;
}

Readouts::Snapshot Readouts::snapshot() const {
    Snapshot all;
    for (const ContactReadout& contact : contacts_) all.contacts.push_back(contact.snapshot());
    for (const EdgeReadout& edge : edges_) all.edges.push_back(edge.snapshot());
    all.intervals = intervals_;
    return all;
}

void Readouts::resume(const Snapshot& snapshot) {
    require(snapshot.contacts.size() == contacts_.size() && snapshot.edges.size() == edges_.size(),
            "snapshot", "of the same read-outs", static_cast<double>(snapshot.contacts.size()));
    for (std::size_t i = 0; i < contacts_.size(); ++i) contacts_[i].resume(snapshot.contacts[i]);
    for (std::size_t i = 0; i < edges_.size(); ++i) edges_[i].resume(snapshot.edges[i]);
    intervals_ = snapshot.intervals;
}

void Readouts::step(TimePoint now) {
    estimated_ = !contacts_.empty() && intervals_until(now) > intervals_;
    if (estimated_) {
        intervals_ = intervals_until(now);
        for (std::size_t i = 0; i < contacts_.size(); ++i)
            estimates_[i].estimate = contacts_[i].estimate(now);
    }
    touches_.clear();
    for (EdgeReadout& edge : edges_)
        if (const EdgeTouch* touch = edge.next()) {
            touches_.push_back(*touch);
            edge.take();
        }
}

std::size_t Readouts::bytes() const {
    std::size_t bytes =
        sizeof *this + estimates_.capacity() * sizeof(PatchContact) + touches_.capacity() * sizeof(EdgeTouch);
    for (const ContactReadout& contact : contacts_) bytes += contact.bytes();
    for (const EdgeReadout& edge : edges_) bytes += edge.bytes();
    return bytes;
}

}  // namespace afferent
