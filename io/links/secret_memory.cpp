#include "afferent/io/links/secret_memory.hpp"

#include <sodium.h>

#include <new>
#include <stdexcept>

namespace afferent {

void start_sodium() {
    static const bool ready = ::sodium_init() >= 0;
    if (!ready) throw std::runtime_error("libsodium cannot start: the system has no random numbers");
}

SecretMemory::SecretMemory(std::size_t size) : size_(size) {
    start_sodium();
    bytes_.reset(static_cast<unsigned char*>(::sodium_malloc(size)));
    if (!bytes_) throw std::bad_alloc();
    ::sodium_memzero(bytes_.get(), size);
}

void SecretMemory::Release::operator()(unsigned char* bytes) const noexcept { ::sodium_free(bytes); }

}  // namespace afferent
