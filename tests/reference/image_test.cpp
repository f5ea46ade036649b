// SPDX-License-Identifier: GPL-3.0-or-later
//
// The reference's images against closed forms: where they lie, and what becomes of their light.
#include <gtest/gtest.h>

#include <memory>

#include "tests/reference/generated_image.h"
#include "tests/reference/image_hits.h"
#include "tests/reference/reference_renderer.h"
#include "tests/support/view_text.h"

namespace mote::reference {
namespace {

using test::imageOf;

constexpr double roundingOfSums = 1e-12;  // doubles, a few sums

render::Scene sceneOf(std::uint32_t width, std::uint32_t height, double opacity,
                      std::shared_ptr<const storage::ColorImage> image) {
    render::Scene scene{test::viewOf("{'width': 8, 'height': 8, 'background': [1, 1, 1], "
                                     "'layers': [{'dataset': 'a/b', 'image': {}}]}"),
                        {{.image = std::move(image)}}};
    scene.view.width = width;
    scene.view.height = height;
    scene.view.layers[0].opacity = opacity;
    return scene;
}

void expectLight(const glm::dvec3& a, const glm::dvec3& b) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], roundingOfSums);
}

TEST(ReferenceImages, OneToOneEachPixelIsItsOwn) {
    const auto image = imageOf("noise", 3);
    const auto picture = render(sceneOf(image->width, image->height, 1.0, image));
    for (std::uint32_t y = 0; y < image->height; ++y) {
        for (std::uint32_t x = 0; x < image->width; ++x)
            expectLight(picture.at(x, y), glm::dvec3(image->at(x, y)));
    }
}

TEST(ReferenceImages, HalfAsLargeItIsTheMeanOfFour) {
    const auto image = imageOf("noise", 3);
    ASSERT_TRUE(image->width % 2 == 0 && image->height % 2 == 0);
    const auto picture = render(sceneOf(image->width / 2, image->height / 2, 1.0, image));
    const auto at = [&](std::uint32_t x, std::uint32_t y) { return glm::dvec3(image->at(x, y)); };
    expectLight(picture.at(2, 1), 0.25 * (at(4, 2) + at(5, 2) + at(4, 3) + at(5, 3)));
}

TEST(ReferenceImages, LargerItGoesEvenlyFromPixelToPixel) {
    const auto image = std::make_shared<storage::ColorImage>(
        storage::ColorImage{2, 1, 2.0, 1.0, {glm::vec3(0.0F), glm::vec3(1.0F, 0.5F, 0.25F)}});
    const auto picture = render(sceneOf(16, 8, 1.0, image));
    // Between the pixels' centres, at 4 and 12, a 16th more from pixel to pixel; beyond, as it ends.
    expectLight(picture.at(3, 3), glm::dvec3(0.0));
    expectLight(picture.at(4, 7), glm::dvec3(1.0, 0.5, 0.25) / 16.0);
    expectLight(picture.at(8, 0), 9.0 / 16.0 * glm::dvec3(1.0, 0.5, 0.25));
    expectLight(picture.at(12, 0), glm::dvec3(1.0, 0.5, 0.25));
}

TEST(ReferenceImages, ItKeepsItsShapeInTheMiddle) {
    const auto image = std::make_shared<storage::ColorImage>(
        storage::ColorImage{2, 1, 2.0, 1.0, {glm::vec3(0.25F), glm::vec3(0.25F)}});
    const auto picture = render(sceneOf(10, 8, 0.5, image));
    const glm::dvec3 mixed(0.5 * 0.25 + 0.5);
    // 10 x 5, from 1 1/2 to 6 1/2.
    expectLight(picture.at(0, 0), glm::dvec3(1.0));
    expectLight(picture.at(4, 1), 0.5 * (mixed + 1.0));
    expectLight(picture.at(9, 2), mixed);
    expectLight(picture.at(0, 6), 0.5 * (mixed + 1.0));
    expectLight(picture.at(0, 7), glm::dvec3(1.0));
}

TEST(ReferenceImages, AClipCutsInThePictureFromItsMiddle) {
    auto scene = sceneOf(8, 4, 1.0,
                         std::make_shared<storage::ColorImage>(storage::ColorImage{
                             2, 1, 2.0, 1.0, {glm::vec3(0.25F, 0.5F, 0.0F), glm::vec3(0.25F, 0.5F, 0.0F)}}));
    scene.view.layers = test::viewOf(
                            "{'width': 8, 'height': 4, 'layers': [{'dataset': 'a/b', 'image': {}, "
                            "'clipBox': {'min': [-0.5, 0, -1], 'max': [0.3, 1, 1]}}]}")
                            .layers;
    const glm::dvec3 own(0.25, 0.5, 0.0), white(1.0);
    const auto picture = render(scene);
    // The longer side goes from -1 to 1: x from the third pixel to the fifth, whose middle is at 1/8; the
    // upper half.
    expectLight(picture.at(4, 0), own);
    expectLight(picture.at(4, 1), own);
    expectLight(picture.at(4, 2), white);
    expectLight(picture.at(2, 1), own);
    expectLight(picture.at(1, 1), white);
    expectLight(picture.at(6, 1), white);
}

TEST(ReferenceImages, ALaterOneLiesOverAnEarlier) {
    auto scene = sceneOf(4, 4, 1.0, imageOf("even", 0));
    scene.view.layers.push_back(scene.view.layers[0]);
    scene.layers.push_back({.image = imageOf("even", 3)});
    const auto &earlier = *scene.layers[0].image, &later = *scene.layers[1].image;
    expectLight(render(scene).at(1, 1), glm::dvec3(later.at(0, 0)));
    ASSERT_NE(earlier.at(0, 0), later.at(0, 0));
}

}  // namespace
}  // namespace mote::reference
