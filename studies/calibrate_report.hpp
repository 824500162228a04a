// What a calibration found: for programs, for people, and as pictures.
#pragma once

#include <ostream>

#include "afferent/io/pictures/scatter_picture.hpp"
#include "afferent/runtime/summary.hpp"
#include "afferent/studies/calibrate.hpp"

namespace afferent {

Summary summary_of(const SceneFit& fit);
void print(const SceneFit& fit, std::ostream& out);
// The drive of each interval against its force, thinned out, and the fitted line.
ScatterPicture drive_picture(const SceneFit& fit);
// The error of the filter's expectation against the standard deviation that it expects.
ScatterPicture motion_picture(const MotionFit& fit);

}  // namespace afferent
