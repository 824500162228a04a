// afferent hand --zero: the readings of a hand's untouched sensors.
#pragma once

#include "afferent/scene/scene.hpp"

namespace afferent {

// Prints the line for the scene, and on standard error what it hides. Throws Failure.
void print_zero(Scene scene);

}  // namespace afferent
