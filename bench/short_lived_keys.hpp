// A folder of keys as `afferent keys` makes it, removed with the object.
#pragma once

#include <filesystem>
#include <random>
#include <stdexcept>
#include <string>

#include "afferent/io/links/certificate.hpp"
#include "afferent/io/links/key_folder.hpp"

namespace afferent {

class ShortLivedKeys {
  public:
    ShortLivedKeys()
        : keys_{std::filesystem::temp_directory_path() /
                ("afferent-keys-" + std::to_string(std::random_device()()))} {
        std::filesystem::create_directory(keys_.folder);
        for (const LinkEnd link_end : {LinkEnd::coprocessor, LinkEnd::hand})
            if (const auto written = write_certificate(name(link_end), keys_.certificate(link_end),
                                                       keys_.private_key(link_end));
                !written)
                throw std::runtime_error(written.error().text);
    }
    ~ShortLivedKeys() {
        std::error_code ignored;
        std::filesystem::remove_all(keys_.folder, ignored);
    }
    ShortLivedKeys(const ShortLivedKeys&) = delete;
    ShortLivedKeys& operator=(const ShortLivedKeys&) = delete;

    const KeyFolder& folder() const noexcept { return keys_; }
    TlsCredentials credentials(LinkEnd own) const { return keys_.credentials(own); }

  private:
    KeyFolder keys_;
};

}  // namespace afferent
