// SPDX-License-Identifier: GPL-3.0-or-later
//
// The reference's meshes against closed forms: what of a pixel they cover, how light falls on them, what lies
// behind several of their surfaces, their shadows and wires.
#include <gtest/gtest.h>

#include <cmath>

#include "protocol/scene/srgb.h"
#include "tests/reference/reference_renderer.h"
#include "tests/support/view_text.h"

namespace mote::reference {
namespace {

/// Squares across the line of sight, from -half to half, each at a height z.
std::shared_ptr<const render::MeshSurface> squares(std::initializer_list<double> heights, double half = 1.0) {
    storage::SurfaceMesh mesh;
    Bounds bounds{glm::dvec3(-half, -half, 1e9), glm::dvec3(half, half, -1e9)};
    for (const double z : heights) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const glm::dvec2 at : {glm::dvec2(-half, -half), {half, -half}, {half, half}, {-half, half}}) {
            mesh.positions.emplace_back(at.x, at.y, z);
            mesh.normals.emplace_back(0.0F, 0.0F, 1.0F);
        }
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
        bounds.min.z = std::min(bounds.min.z, z);
        bounds.max.z = std::max(bounds.max.z, z);
    }
    return std::make_shared<const render::MeshSurface>(std::move(mesh), bounds);
}

/// 40 x 40 pixels of 1/20, seen from (0, 0, `eye`), in front of black.
render::Scene sceneOf(const std::shared_ptr<const render::MeshSurface>& mesh, const std::string& style,
                      int eye = 4) {
    render::Scene scene{
        test::viewOf("{'width': 40, 'height': 40, 'camera': {'eye': [0, 0, " + std::to_string(eye) +
                     "], 'target': [0, 0, 0], 'orthographicHeight': 2}, 'layers': [{'mesh': {" + style +
                     "}}]}"),
        {{.mesh = mesh}}};
    return scene;
}

constexpr const char* white = "'color': [1, 1, 1], 'light': {'ambient': 1, 'diffuse': 0}";

double meshInk(const Picture& picture) {
    double sum = 0.0;
    for (const auto& color : picture.linear) sum += color.x;
    return sum;
}

TEST(ReferenceMesh, CoversAsMuchAsItIsLarge) {
    // Edges where the eight samples of a pixel tell them: at multiples of a quarter of it.
    for (const double half : {0.5, 0.5125, 0.525, 0.2375}) {
        const double pixels = 2.0 * half * 20.0;
        EXPECT_NEAR(meshInk(render(sceneOf(squares({0.0}, half), white))), pixels * pixels,
                    0.011 * pixels * pixels)
            << half;
    }
}

TEST(ReferenceMesh, IsLitByTheAngleToTheLightOnBothSides) {
    const double third = std::cos(std::acos(-1.0) / 3.0);
    for (const int eye : {4, -4}) {
        const auto picture = render(sceneOf(squares({0.0}),
                                            "'color': [1, 1, 1], 'light': {'direction': [0, "
                                            "0.8660254037844386, 0.5], 'ambient': 0.25, 'diffuse': 0.5}",
                                            eye));
        EXPECT_NEAR(picture.at(20, 20).x, 0.25 + 0.5 * third, 1e-12) << eye;
    }
    const auto shining = render(sceneOf(squares({0.0}),
                                        "'color': [0, 0, 0], 'light': {'direction': [0, 0, 1], "
                                        "'ambient': 0, 'diffuse': 0, 'specular': 0.5}"));
    EXPECT_NEAR(shining.at(20, 20).x, 0.5, 1e-12);
}

TEST(ReferenceMesh, EachSurfaceHidesItsShareOfWhatLiesBehind) {
    const auto picture = render(sceneOf(squares({-0.5, 0.0, 0.5}), std::string(white) + ", 'opacity': 0.3"));
    EXPECT_NEAR(picture.at(13, 25).x, 1.0 - 0.7 * 0.7 * 0.7, 1e-12);
}

TEST(ReferenceMesh, HidesADotBehindItAndLiesBehindOneInFront) {
    auto scene = sceneOf(squares({0.0}), std::string(white) + ", 'opacity': 0.5");
    render::Dot red{.x = 20.5F, .y = 20.5F, .depth = 4.5, .radius = 2.0F, .color = {1.0F, 0.0F, 0.0F}};
    scene.dots = std::make_shared<const render::Dots>(render::Dots{red});
    EXPECT_NEAR(render(scene).at(20, 20).y, 0.5, 1e-12);
    EXPECT_NEAR(render(scene).at(20, 20).x, 1.0, 1e-12);
    red.depth = 3.5;
    scene.dots = std::make_shared<const render::Dots>(render::Dots{red});
    EXPECT_EQ(render(scene).at(20, 20), glm::dvec3(1.0, 0.0, 0.0));
}

TEST(ReferenceMesh, CastsAShadowOnItself) {
    // The upper square lies in the light of the left half of the lower one, which is twice as large.
    auto mesh = squares({0.0}, 1.0)->mesh();
    const auto upper = squares({0.5}, 0.25)->mesh();
    mesh.positions.insert(mesh.positions.end(), upper.positions.begin(), upper.positions.end());
    mesh.normals.insert(mesh.normals.end(), upper.normals.begin(), upper.normals.end());
    for (const auto& [a, b, c] : upper.triangles) mesh.triangles.push_back({a + 4, b + 4, c + 4});
    const auto both = std::make_shared<const render::MeshSurface>(std::move(mesh),
                                                                  Bounds{{-1.0, -1.0, 0.0}, {1.0, 1.0, 0.5}});
    const auto picture = render(sceneOf(both,
                                        "'color': [1, 1, 1], 'light': {'direction': [1, 0, 1], 'ambient': "
                                        "0.25, 'diffuse': 0.5, 'shadow': true}"));
    EXPECT_NEAR(picture.at(10, 20).x, 0.25,
                1e-12);  // x = -0.475: beneath the upper square as the light falls
    EXPECT_NEAR(picture.at(30, 20).x, 0.25 + 0.5 * std::sqrt(0.5), 1e-12);
}

TEST(ReferenceMesh, AWireIsAPixelWideAndSeenThrough) {
    const auto picture = render(sceneOf(squares({0.0}, 0.525), std::string(white) + ", 'wire': true"));
    EXPECT_EQ(picture.at(20, 25).x, 0.0);         // within a triangle
    EXPECT_EQ(picture.at(20, 19).x, 1.0);         // on the diagonal
    EXPECT_NEAR(picture.at(9, 20).x, 0.5, 0.13);  // the left edge goes through the middle of this column
    EXPECT_EQ(picture.at(8, 20).x, 0.0);
}

}  // namespace
}  // namespace mote::reference
