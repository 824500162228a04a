// The keys of one direction of a session, one after the other.
#pragma once

#include "afferent/io/links/secret_key.hpp"

namespace afferent {

// Each key comes from a secret that is replaced by its successor in the same step, both by BLAKE2b: the keys
// used before cannot be found from a later secret.
class KeyChain {
  public:
    explicit KeyChain(const SecretKey& secret) : secret_(secret) {}

    SecretKey next_key();

  private:
    SecretKey secret_;
};

}  // namespace afferent
