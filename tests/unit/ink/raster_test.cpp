// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/raster.h"

#include <gtest/gtest.h>

#include <limits>

namespace mote::render {
namespace {

TEST(Raster, PlacesOutsideAreThoseAtItsSide) {
    Raster<int> raster(3, 2);
    raster.at(0, 0) = 1;
    raster.at(2, 1) = 2;
    EXPECT_EQ(raster.near(-1e9, -1.0), 1);
    EXPECT_EQ(raster.near(1e300, 7.0), 2);
    EXPECT_EQ(raster.near(2.5, 1.5), 2);
    EXPECT_EQ(raster.near(std::numeric_limits<double>::quiet_NaN(), 0.0), 1);
}

}  // namespace
}  // namespace mote::render
