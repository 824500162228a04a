// The columns of the read-outs' tables, as docs/readouts.md has them.
#include "afferent/decoders/readout.hpp"

#include <gtest/gtest.h>

#include <string>

namespace afferent {
namespace {

template <class Readout>
std::string columns_of() {
    std::string names;
    Readout().columns(
        [&](const char* name, const auto&) { names += (names.empty() ? "" : ",") + std::string(name); });
    return names;
}

TEST(Readouts, HaveTheColumnsOfTheirTables) {
    EXPECT_EQ(columns_of<PatchContact>(),
              "time,patch,contact,afferents,force_n,force_sigma_n,x_mm,x_sigma_mm,y_mm,y_sigma_mm,area_mm2,"
              "area_sigma_mm2,velocity_x_mm_per_s,velocity_x_sigma_mm_per_s,velocity_y_mm_per_s,"
              "velocity_y_sigma_mm_per_s");
    EXPECT_EQ(columns_of<EdgeTouch>(),
              "time,patch,told,afferents,orientation_deg,orientation_sigma_deg,direction_deg,speed_mm_per_s,"
              "speed_sigma_mm_per_s");
    EXPECT_EQ(
        columns_of<PatchTexture>(),
        "time,patch,afferents,events,frequency_hz,frequency_sigma_hz,period_mm,period_sigma_mm,direction_deg,"
        "direction_sigma_deg,speed_mm_per_s,speed_sigma_mm_per_s,roughness_hz,roughness_sigma_hz");
}

}  // namespace
}  // namespace afferent
