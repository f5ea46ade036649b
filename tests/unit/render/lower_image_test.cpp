// SPDX-License-Identifier: GPL-3.0-or-later
//
// The fragments of an image: the same of parts of a picture as of all of it. What they are, the golden views
// hold to the reference.
#include "server/render/layers/image/lower_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <utility>

#include "tests/support/random.h"

namespace mote::render {
namespace {

std::shared_ptr<const storage::ColorImage> imageOf(std::uint32_t width, std::uint32_t height) {
    test::Random random(width, height);
    storage::ColorImage image{width, height, width - 0.25, 1.0 * height, {}};
    for (std::uint32_t i = 0; i < width * height; ++i)
        image.values.emplace_back(static_cast<float>(random.unit()), 0.5F, static_cast<float>(i));
    return std::make_shared<const storage::ColorImage>(std::move(image));
}

FramePlan planOf(std::shared_ptr<const storage::ColorImage> image, std::uint32_t width,
                 std::uint32_t height) {
    FramePlan plan{.width = width, .height = height, .camera = {}};
    const Quality quality = Quality::exact();
    SelectionCache selections;
    Lowering lowering{.plan = plan,
                      .quality = quality,
                      .selections = selections,
                      .device = {},
                      .reading = Reading::all,
                      .pixels = 1.0,
                      .slabs = 1,
                      .stop = {}};
    Layer layer{"a/b", 0, glm::dmat4(1.0), proto::ImageStyle{}, 0.5};
    lowerImage(layer, std::move(image), lowering);
    return plan;
}

TEST(LowerImage, PartsAreAsTheWhole) {
    for (const auto& [width, height] : {std::pair(7U, 5U), std::pair(200U, 90U), std::pair(1U, 60U)}) {
        const auto plan = planOf(imageOf(width, height), 53, 31);
        ASSERT_EQ(plan.surfaces.size(), 1U);
        Fragments whole, parts;
        plan.surfaces[0]->make({0, 0, 53, 31}, whole);
        ASSERT_FALSE(whole.empty());
        for (std::uint32_t top = 0; top < 31; top += 8) {
            for (std::uint32_t left = 0; left < 53; left += 9)
                plan.surfaces[0]->make({left, top, std::min(left + 9, 53U), std::min(top + 8, 31U)}, parts);
        }
        ASSERT_EQ(parts.size(), whole.size());
        std::map<std::pair<std::uint32_t, std::uint32_t>, Fragment> known;
        for (const auto& one : parts) known[{one.row, one.column}] = one;
        for (const auto& one : whole) {
            const auto& other = known.at({one.row, one.column});
            EXPECT_EQ(other.color, one.color);
            EXPECT_EQ(other.opacity, one.opacity);
            EXPECT_TRUE(std::isinf(one.depth));
            EXPECT_LE(one.opacity, 0.5F);
        }
    }
}

TEST(LowerImage, ItsLightIsThatOfTheImage) {
    const auto image = imageOf(200, 90);
    const auto plan = planOf(image, 53, 31);
    Fragments whole;
    plan.surfaces[0]->make({0, 0, 53, 31}, whole);
    glm::dvec3 shown(0.0), held(0.0);
    double shownArea = 0.0, heldArea = 0.0;
    for (const auto& one : whole) {
        shown += static_cast<double>(one.opacity) * glm::dvec3(one.color);
        shownArea += static_cast<double>(one.opacity);
    }
    for (std::uint32_t y = 0; y < image->height; ++y) {
        for (std::uint32_t x = 0; x < image->width; ++x) {
            const double area = x + 1 < image->width ? 1.0 : 0.75;
            held += area * glm::dvec3(image->at(x, y));
            heldArea += area;
        }
    }
    // Single precision: a sum of some ten thousand parts, each of them right to 2^-23 or so.
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(shown[c] / shownArea, held[c] / heldArea, 1e-5 * held[c] / heldArea);
}

}  // namespace
}  // namespace mote::render
