// A ring of values that keeps its memory.
#pragma once

#include <boost/circular_buffer.hpp>

namespace afferent {

// Assigned to another with room for as much, it allocates nothing.
template <class T>
class RingBuffer : public boost::circular_buffer<T> {
  public:
    using boost::circular_buffer<T>::circular_buffer;
    RingBuffer(const RingBuffer&) = default;
    RingBuffer(RingBuffer&&) noexcept = default;
    RingBuffer& operator=(RingBuffer&&) noexcept = default;
    RingBuffer& operator=(const RingBuffer& other) {
        if (this == &other) return *this;
        this->clear();
        if (this->capacity() < other.capacity()) this->set_capacity(other.capacity());
        this->insert(this->end(), other.begin(), other.end());
        return *this;
    }

    // Where it is full, it doubles its room: a push would overwrite the first element.
    void append(const T& value) {
        if (this->full()) this->set_capacity(2 * this->capacity());
        this->push_back(value);
    }
};

}  // namespace afferent
