// SPDX-License-Identifier: GPL-3.0-or-later
//
// What surroundings keep away of the ambient light, against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "server/render/layers/ink/mesh_modalities.h"
#include "tests/support/generated_mesh.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::render {
namespace {

constexpr std::uint32_t occlusionSide = 96;

/// Rectangles, each by a corner and its sides.
struct Rectangle {
    glm::vec3 corner, right, up;
};

MeshSurface surfaceOf(const std::vector<Rectangle>& rectangles) {
    storage::SurfaceMesh mesh;
    Bounds bounds{glm::dvec3(HUGE_VAL), glm::dvec3(-HUGE_VAL)};
    for (const auto& [corner, right, up] : rectangles) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        const glm::vec3 normal = glm::normalize(glm::cross(right, up));
        for (const auto& at : {corner, corner + right, corner + right + up, corner + up}) {
            mesh.positions.push_back(at);
            mesh.normals.push_back(normal);
            bounds = bounds.united({glm::dvec3(at), glm::dvec3(at)});
        }
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
    }
    mesh.edges = test::edgesOf(mesh);
    return {std::move(mesh), bounds};
}

/// Grey under ambient light alone, seen from above.
Raster<float> greyOf(const MeshSurface& surface, double height, double occlusion) {
    Camera camera;
    camera.eye = {0.0, 0.0, 50.0};
    camera.target = glm::dvec3(0.0);
    camera.up = {0.0, 1.0, 0.0};
    camera.orthographicHeight = height;
    auto style = test::usualInk();
    style.light.ambient = 1.0;
    style.light.diffuse = 0.0;
    style.occlusion = occlusion;
    return modalitiesOf(surface, glm::dmat4(1.0), style, test::planOf(camera, occlusionSide, occlusionSide),
                        {})
        .modalities.grey;
}

const Rectangle floor{{-10.0F, -10.0F, 0.0F}, {20.0F, 0.0F, 0.0F}, {0.0F, 20.0F, 0.0F}};

TEST(AmbientOcclusion, NothingKeepsLightFromAPlain) {
    for (const float value : greyOf(surfaceOf({floor}), 8.0, 1.0).values) EXPECT_EQ(value, 1.0F);
}

TEST(AmbientOcclusion, AWallKeepsAwayWhatItCoversOfTheSky) {
    // Along x at y = 0, as high as 1: at the distance d it covers (1 - cos(atan(1 / d))) / 2 of the light.
    const Rectangle wall{{-10.0F, 0.0F, 0.0F}, {20.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 1.0F}};
    const auto surface = surfaceOf({floor, wall});
    for (const double occlusion : {1.0, 0.5}) {
        const auto grey = greyOf(surface, 8.0, occlusion);
        for (const double distance : {0.3, 0.6, 1.0, 2.0}) {
            const auto row = static_cast<std::uint32_t>(occlusionSide / 2 - distance / 8.0 * occlusionSide);
            const double there = (occlusionSide / 2 - row - 0.5) * 8.0 / occlusionSide;
            double mean = 0.0;
            for (std::uint32_t column = 16; column < occlusionSide - 16; ++column)
                mean += static_cast<double>(grey.at(column, row)) / (occlusionSide - 32);
            const double closed = 0.5 * (1.0 - std::cos(std::atan(1.0 / there)));
            EXPECT_NEAR(mean, 1.0 - occlusion * closed, 0.03) << "at " << there;
        }
    }
}

TEST(AmbientOcclusion, WhatIsFarAwayKeepsNothing) {
    // A ceiling that begins beside the picture: rays end before they reach it.
    const Rectangle ceiling{{-10.0F, 5.0F, 9.0F}, {20.0F, 0.0F, 0.0F}, {0.0F, 5.0F, 0.0F}};
    for (const float value : greyOf(surfaceOf({floor, ceiling}), 4.0, 1.0).values) EXPECT_EQ(value, 1.0F);
}

TEST(AmbientOcclusion, TheShareThatItHasCounts) {
    const Rectangle wall{{-10.0F, 0.0F, 0.0F}, {20.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 1.0F}};
    const auto surface = surfaceOf({floor, wall});
    const auto none = greyOf(surface, 8.0, 0.0), half = greyOf(surface, 8.0, 0.5),
               all = greyOf(surface, 8.0, 1.0);
    for (std::size_t i = 0; i < none.values.size(); ++i) {
        EXPECT_EQ(none.values[i], 1.0F);
        EXPECT_NEAR(half.values[i], 0.5F * (none.values[i] + all.values[i]), 1e-5F);
    }
}

}  // namespace
}  // namespace mote::render
