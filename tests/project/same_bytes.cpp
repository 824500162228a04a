// Whether this build predicts spikes as every other does: for same_bytes.py.
#include "tests/io/wire/wandering_trains.hpp"

int main() { return afferent::payload_checksum() == afferent::expected_checksum ? 0 : 1; }
