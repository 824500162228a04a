// The name of a test over a transport: the transport's.
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace afferent {

inline std::string transport_name(const testing::TestParamInfo<const char*>& transport) {
    return transport.param;
}

}  // namespace afferent
