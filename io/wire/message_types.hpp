// The messages of the wire, defined: generated from proto/aer.proto. Headers that only pass them on include
// messages.hpp.
#pragma once

#include "afferent/proto/aer.pb.h"
