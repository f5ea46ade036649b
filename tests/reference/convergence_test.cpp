// SPDX-License-Identifier: GPL-3.0-or-later
//
// The reference's steps are small enough, and its answer does not depend on how it was computed.
#include <gtest/gtest.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "protocol/scene/srgb.h"
#include "tests/reference/reference_renderer.h"
#include "tests/support/beams.h"
#include "tests/support/view_text.h"

namespace mote::reference {
namespace {

render::Scene beamScene() {
    const auto points = test::beam({.core = 20000, .halo = 2000, .filaments = 1000});
    return {test::viewOf("{'width': 96, 'height': 54, 'camera': {'eye': [1, 0.7, 2.2], 'target': [0, 0, 0]},"
                         "'layers': [{'particles': {'volume': {'curve': [{'density': 0.2, 'opacity': 0},"
                         "{'density': 1, 'opacity': 0.6}]}, 'points': {'opacity': 1}}}]}"),
            {{.step = test::MemoryStep::make(points, {.leafCapacity = 32, .volumeLevel = 5})}}};
}

/// The greatest difference, in 8-bit steps of sRGB before rounding.
double worst(const Picture& a, const Picture& b) {
    double result = 0.0;
    for (std::size_t i = 0; i < a.linear.size(); ++i) {
        const glm::dvec3 difference = 255.0 * glm::abs(linearToSrgb(a.linear[i]) - linearToSrgb(b.linear[i]));
        result = std::max({result, difference.x, difference.y, difference.z});
    }
    return result;
}

TEST(ReferenceConvergence, HalfTheStepChangesNothingVisible) {
    const auto scene = beamScene();
    const auto coarse = render(scene, {4.0});
    const auto usual = render(scene);
    const auto half = render(scene, {32.0});
    // Less than half a step of 8 bits is less than the rounding of a picture.
    EXPECT_LT(worst(usual, half), 0.5);
    // The midpoint rule is of second order: a step four times smaller errs about sixteen times less, less so
    // where the curves have their kinks; a quarter is asked for.
    EXPECT_LT(worst(usual, half), 0.25 * worst(coarse, half));
    EXPECT_GT(worst(coarse, half), 0.0);
}

TEST(ReferenceConvergence, ThePictureIsTheSameEachTime) {
    const auto scene = beamScene();
    EXPECT_EQ(render(scene).linear, render(scene).linear);
}

}  // namespace
}  // namespace mote::reference
