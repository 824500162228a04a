// Recorded images of forces, laid over the skin.
#pragma once

#include <cstddef>

#include "afferent/encoders/receptive_fields.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// What each element of the scene feels of the pixels of an image, row by row from the top, which spans the
// rectangle around all outlines on the map: the part of each pixel's force that lies on its cell. Every patch
// with elements has an outline.
ReceptiveFields image_on_skin(const Plan& plan, std::size_t rows, std::size_t columns);

}  // namespace afferent
