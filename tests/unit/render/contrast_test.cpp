// SPDX-License-Identifier: GPL-3.0-or-later
//
// Depth contrast (docs/PICTURE.md): what is drawn is told once more, pixel by pixel and in plain sums;
// nothing is drawn where nothing is ambiguous; and of solids in a scene the nearer one is made stand out.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>

#include "protocol/scene/fields/resolve.h"
#include "protocol/scene/view_message.h"
#include "server/render/cpu/cpu_device.h"
#include "server/render/layers/contrast/depth_order.h"
#include "server/render/layers/contrast/lower_contrast.h"
#include "server/render/layers/make_frame_plan.h"
#include "tests/support/generated_mesh.h"
#include "tests/support/hybrid_scene.h"
#include "tests/support/random.h"

namespace mote::render {
namespace {

// ------------------------------------------------------------------------------------ the drawing, by sums

/// Means of 2 radius + 1 pixels, taken again and again, as weights of the pixels around one.
std::vector<double> kernel(int radius, int passes) {
    std::vector<double> made{1.0};
    for (int pass = 0; pass < passes; ++pass) {
        std::vector<double> wider(made.size() + 2 * static_cast<std::size_t>(radius), 0.0);
        for (std::size_t i = 0; i < made.size(); ++i) {
            for (std::size_t k = 0; k <= 2 * static_cast<std::size_t>(radius); ++k)
                wider[i + k] += made[i] / (2.0 * radius + 1.0);
        }
        made = wider;
    }
    return made;
}

double blurred(const std::function<double(std::uint32_t, std::uint32_t)>& values, const DepthOrder& order,
               int x, int y, const std::vector<double>& weights) {
    const int reach = static_cast<int>(weights.size() / 2);
    const auto weight = [&](int i) { return weights[static_cast<std::size_t>(i + reach)]; };
    double sum = 0.0;
    for (int j = -reach; j <= reach; ++j) {
        for (int i = -reach; i <= reach; ++i) {
            const bool inside = x + i >= 0 && y + j >= 0 && x + i < static_cast<int>(order.layer.width) &&
                                y + j < static_cast<int>(order.layer.height);
            if (inside)
                sum += weight(i) * weight(j) *
                       values(static_cast<std::uint32_t>(x + i), static_cast<std::uint32_t>(y + j));
        }
    }
    return sum;
}

double smoothstep(double x) {
    x = std::clamp(x, 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

struct Expected {
    double contour = 0.0, held = 0.0;
};

/// docs/PICTURE.md, "Depth contrast", of layer 0 before layer 1 in a picture of 720 lines' pixels.
Expected expectedAt(const DepthOrder& order, int x, int y) {
    const auto wide = kernel(4, 3), narrow = kernel(1, 2), reading = kernel(6, 3);
    const auto sum = [&](int layer, const Raster<float>* values, const std::vector<double>& weights) {
        return blurred(
            [&](auto i, auto j) {
                if (order.layer.at(i, j) != layer) return 0.0;
                return values != nullptr ? static_cast<double>(values->at(i, j)) : 1.0;
            },
            order, x, y, weights);
    };
    const double near = sum(0, nullptr, wide), far = sum(1, nullptr, wide);
    if (!(near > 1e-4) || !(far > 1e-4)) return {};
    const auto differ = [&](auto i, auto j, auto u, auto v) {
        return order.layer.at(i, j) != order.layer.at(u, v) ||
               std::abs(order.depth.at(i, j) - order.depth.at(u, v)) > 0.02 * order.extent;
    };
    const double edges = blurred(
        [&](auto i, auto j) {
            return (i + 1 < order.layer.width && differ(i, j, i + 1, j)) ||
                           (j + 1 < order.layer.height && differ(i, j, i, j + 1))
                       ? 1.0
                       : 0.0;
        },
        order, x, y, reading);
    // Three means of 13 pixels have the variance 3 (13^2 - 1) / 12; a line through their middle has this
    // share.
    const double complexity = edges * std::sqrt(42.0 * 2.0 * std::numbers::pi);
    const double shares = std::min(sum(0, &order.share, wide) / near, sum(1, &order.share, wide) / far);
    const double gap = (sum(1, &order.depth, wide) / far - sum(0, &order.depth, wide) / near) / order.extent;
    const double ends =
        blurred([&](auto i,
                    auto j) { return order.layer.at(i, j) == 1 ? 1.0 - order.own[0].at(i, j) / 255.0 : 0.0; },
                order, x, y, wide) /
        far;
    const double tones = std::abs(sum(0, &order.tone, wide) / near - sum(1, &order.tone, wide) / far);
    const double ambiguity = std::clamp(complexity - 0.25, 0.0, 1.0) * smoothstep((shares - 0.1) / 0.4) *
                             smoothstep(gap / 0.03) * ends * (1.0 - std::min(1.0, tones / 0.5));
    const double beside = 4.0 * near * far;
    const double line = sum(0, nullptr, narrow), other = sum(1, nullptr, narrow), onLine = 4.0 * line * other;
    const double within = line + other > 1e-4 ? line / (line + other) : near / (near + far);
    return {1.0 - (1.0 - 0.8 * ambiguity * onLine) *
                      (1.0 - 0.35 * ambiguity * beside * std::min(1.0, 2.0 * within)),
            0.85 * ambiguity * beside * std::min(1.0, 2.0 * (1.0 - within))};
}

/// A disc of layer 0 before stripes of layer 1, which part nothing from nothing.
DepthOrder discBeforeStripes(std::uint32_t width, std::uint32_t height) {
    DepthOrder order(width, height, 2);
    order.extent = 4.0;
    test::Random random(width, height);
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const bool disc = std::hypot(x - 0.5 * width, y - 0.4 * height) < 0.25 * height;
            const bool stripe = (x + y / 3) % 24 < 15;
            order.own[1].at(x, y) = stripe ? 255 : 0;
            order.own[0].at(x, y) = disc ? 230 : 0;
            if (!disc && !stripe) continue;
            order.layer.at(x, y) = disc ? 0 : 1;
            order.depth.at(x, y) = order.front.at(x, y) =
                static_cast<float>((disc ? 5.0 : 6.0) + 0.01 * random.unit());
            order.share.at(x, y) = disc ? 0.9F : 0.4F;
            order.tone.at(x, y) = disc ? 0.6F : 0.5F;
        }
    }
    return order;
}

constexpr glm::vec3 ofContour(0.0F, 1.0F, 0.0F), ofHalo(0.0F, 0.0F, 1.0F);
const ContrastStyle plainStyle{.contour = ofContour, .rim = 0.35, .background = ofHalo};

Fragments marksOf(const DepthOrder& order, const ContrastStyle& style = plainStyle) {
    Fragments made;
    const auto maker = contrastOf(order, style, {});
    if (maker != nullptr) maker->make({0, 0, order.layer.width, order.layer.height}, made);
    return made;
}

TEST(DepthContrast, IsWhatPlainSumsSay) {
    // Over the border of a tile of 128 pixels.
    const auto order = discBeforeStripes(190, 150);
    std::map<std::pair<int, int>, Expected> drawn;
    for (const auto& mark : marksOf(order)) {
        auto& here = drawn[{mark.column, mark.row}];
        (mark.color == ofContour ? here.contour : here.held) = static_cast<double>(mark.opacity);
        const double nearest = mark.color == ofContour ? 4.98 : 5.0,
                     farthest = mark.color == ofContour ? 5.02 : 6.0;
        EXPECT_GT(mark.depth, nearest);
        EXPECT_LT(mark.depth, farthest);
    }
    ASSERT_GT(drawn.size(), 500U);
    double most = 0.0;
    for (int y = 2; y < 150; y += 5) {
        for (int x = 1; x < 190; x += 4) {
            const auto expected = expectedAt(order, x, y);
            const auto found = drawn.contains({x, y}) ? drawn.at({x, y}) : Expected{};
            // What is below a 512th is left out.
            EXPECT_NEAR(found.contour, expected.contour, expected.contour < 0.0021 ? 0.0021 : 1e-3)
                << x << ' ' << y;
            EXPECT_NEAR(found.held, expected.held, expected.held < 0.0021 ? 0.0021 : 1e-3) << x << ' ' << y;
            most = std::max(most, expected.held);
        }
    }
    EXPECT_GT(most, 0.2);
}

TEST(DepthContrast, PartsAreAsTheWhole) {
    const auto order = discBeforeStripes(190, 150);
    const auto maker = contrastOf(order, plainStyle, {});
    std::map<std::tuple<std::uint32_t, std::uint32_t, bool>, Fragment> known;
    Fragments parts;
    for (std::uint32_t top = 0; top < 150; top += 16) {
        for (std::uint32_t left = 0; left < 190; left += 50)
            maker->make({left, top, std::min(left + 50, 190U), std::min(top + 16, 150U)}, parts);
    }
    for (const auto& one : parts) known[{one.row, one.column, one.color == ofContour}] = one;
    const auto whole = marksOf(order);
    ASSERT_EQ(parts.size(), whole.size());
    for (const auto& one : whole) {
        const auto& other = known.at({one.row, one.column, one.color == ofContour});
        EXPECT_EQ(other.depth, one.depth);
        EXPECT_EQ(other.opacity, one.opacity);
    }
}

TEST(DepthContrast, GoesEvenlyWithItsAmount) {
    const auto order = discBeforeStripes(120, 90);
    const auto held = [&](double amount) {
        auto style = plainStyle;
        style.amount = amount;
        double sum = 0.0;
        for (const auto& mark : marksOf(order, style))
            sum += mark.color == ofHalo ? static_cast<double>(mark.opacity) : 0.0;
        return sum;
    };
    const double all = held(1.0);
    EXPECT_NEAR(held(0.5), 0.5 * all, 0.01 * all);
    EXPECT_EQ(held(0.0), 0.0);
}

TEST(DepthContrast, OnlyWhatIsAmbiguousIsDrawn) {
    EXPECT_EQ(Ambiguity().amount(), 0.0);
    const Ambiguity most{.complexity = 2.0, .shares = 1.0, .gap = 1.0, .ends = 1.0, .tones = 0.0};
    EXPECT_EQ(most.amount(), 1.0);
    const auto without = [&](double Ambiguity::*what, double value) {
        auto less = most;
        less.*what = value;
        return less.amount();
    };
    EXPECT_EQ(without(&Ambiguity::complexity, 0.25), 0.0);
    EXPECT_EQ(without(&Ambiguity::shares, 0.1), 0.0);
    EXPECT_EQ(without(&Ambiguity::gap, -0.1), 0.0) << "the other one is nearer";
    EXPECT_EQ(without(&Ambiguity::ends, 0.0), 0.0) << "they go through each other";
    EXPECT_EQ(without(&Ambiguity::tones, 0.5), 0.0) << "tones tell";
    EXPECT_NEAR(without(&Ambiguity::tones, 0.25), 0.5, 1e-12);
}

TEST(DepthContrast, WhatDoesNotMeetIsLeftAlone) {
    auto apart = discBeforeStripes(120, 90);
    for (auto& layer : apart.layer.values) layer = layer == 1 ? DepthOrder::nothing : layer;
    EXPECT_EQ(contrastOf(apart, plainStyle, {}), nullptr);
    auto through = discBeforeStripes(120, 90);
    for (auto& own : through.own[0].values) own = 255;
    EXPECT_EQ(contrastOf(through, plainStyle, {}), nullptr) << "the nearer one goes on behind the other";
}

// ---------------------------------------------------------------------------------------------- scenes

storage::SurfaceMesh ballMesh(const glm::dvec3& middle, double radius) {
    constexpr std::uint32_t columns = 48, rows = 24;
    storage::SurfaceMesh mesh;
    for (std::uint32_t i = 0; i < columns; ++i) {
        for (std::uint32_t j = 0; j <= rows; ++j) {
            const double u = 2.0 * std::numbers::pi * i / columns, v = std::numbers::pi * j / rows;
            const glm::dvec3 normal(std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), std::cos(v));
            mesh.positions.emplace_back(middle + radius * normal);
            mesh.normals.emplace_back(normal);
        }
    }
    for (std::uint32_t i = 0; i < columns; ++i) {
        for (std::uint32_t j = 0; j < rows; ++j) {
            const std::uint32_t a = i * (rows + 1) + j, b = (i + 1) % columns * (rows + 1) + j;
            if (j > 0) mesh.triangles.push_back({a, b, b + 1});
            if (j + 1 < rows) mesh.triangles.push_back({a, b + 1, a + 1});
        }
    }
    return mesh;
}

/// A ball of matter of radius 0.3 around (0.5, 0.5, 0.5), and the ball of a mesh beside it on the screen, so
/// deep.
Scene twoBalls(double contrast, double meshAt) {
    const auto field = test::hybridOf(
        {.source = glm::uvec3(48), .low = glm::uvec3(48), .parts = HybridRepresentation::volume},
        [](const glm::dvec3& at) {
            return std::clamp(0.5 + 4.0 * (0.3 - glm::distance(at, glm::dvec3(0.5))), 0.0, 1.0);
        });
    View view{.width = 160,
              .height = 120,
              .camera = parseCamera([] {
                            proto::Camera camera;
                            for (const double x : {0.5, 0.5, 4.0}) camera.add_eye(x);
                            for (const double x : {0.5, 0.5, 0.5}) camera.add_target(x);
                            camera.set_orthographic_height(1.2);
                            return camera;
                        }())
                            .value(),
              .layers = {},
              .depthContrast = contrast};
    view.background = glm::dvec3(1.0);
    proto::HybridStyle style;
    for (const auto& [value, opacity] : {std::pair(0.45, 0.0), std::pair(0.55, 0.99)}) {
        auto& knot = *style.add_curve();
        knot.set_value(value);
        knot.set_opacity(opacity);
    }
    view.layers.push_back({.dataset = "data/a", .style = parseHybridStyle(style).value()});
    view.layers.push_back({.dataset = "data/b", .style = resolved(proto::MeshStyle()).value()});
    return {view, {{.hybrid = field}, {.mesh = test::surfaceOf(ballMesh({0.75, 0.55, meshAt}, 0.2))}}};
}

FramePlan planOf(const Scene& scene) {
    return makeFramePlan(scene, Quality::exact());
}

Fragments contrastIn(const Scene& scene) {
    Fragments made;
    const auto maker = depthContrastOf(scene, planOf(scene), {});
    if (maker != nullptr) maker->make({0, 0, scene.view.width, scene.view.height}, made);
    return made;
}

/// The pixel's place at the scene's scale.
glm::dvec2 placeOf(const Scene& scene, const Fragment& mark) {
    return {0.5 + (mark.column + 0.5 - 0.5 * scene.view.width) / scene.view.height * 1.2,
            0.5 - (mark.row + 0.5 - 0.5 * scene.view.height) / scene.view.height * 1.2};
}

TEST(DepthContrast, TheNearerBallIsOutlinedAndTheFartherHeldBack) {
    for (const double meshAt : {1.3, -0.4}) {
        const auto scene = twoBalls(1.0, meshAt);
        const auto marks = contrastIn(scene);
        ASSERT_GT(marks.size(), 100U) << meshAt;
        const bool meshIsNear = meshAt > 0.5;
        const glm::dvec2 middle = meshIsNear ? glm::dvec2(0.75, 0.55) : glm::dvec2(0.5);
        const double radius = meshIsNear ? 0.2 : 0.3, depth = 4.0 - (meshIsNear ? meshAt : 0.5);
        double held = 0.0, heldOutside = 0.0;
        for (const auto& mark : marks) {
            const double from = glm::distance(placeOf(scene, mark), middle) - radius;
            EXPECT_LT(std::abs(from), 0.14) << "beside the nearer one's outline alone";
            if (mark.color == glm::vec3(scene.view.background)) {
                held += static_cast<double>(mark.opacity);
                if (from > -0.02) heldOutside += static_cast<double>(mark.opacity);
                EXPECT_GT(mark.depth, depth - radius);
            } else {
                EXPECT_LT(mark.depth, depth + 0.05) << "before its matter";
            }
        }
        EXPECT_GT(heldOutside, 0.8 * held);
    }
}

TEST(DepthContrast, BallsThatCutEachOtherAreLeftAlone) {
    // Two alike: each goes on behind the other.
    auto scene = twoBalls(1.0, 0.5);
    scene.layers[1].mesh = test::surfaceOf(ballMesh({0.65, 0.5, 0.5}, 0.3));
    double most = 0.0;
    for (const auto& mark : contrastIn(scene)) {
        // Not where their outlines cross, at the ends of the seam.
        if (std::abs(placeOf(scene, mark).y - 0.5) < 0.15)
            most = std::max(most, static_cast<double>(mark.opacity));
    }
    EXPECT_LT(most, 0.02);
}

TEST(DepthContrast, ElsewhereThePictureIsTheSameToTheByte) {
    CpuDevice device;
    const auto drawn = [&](const Scene& scene) {
        return device.render(planOf(scene), PixelFormat::srgb8, {}).value();
    };
    const auto scene = twoBalls(1.0, 1.3);
    const auto without = drawn(twoBalls(0.0, 1.3)), with = drawn(scene);
    std::vector<bool> marked(std::size_t{160} * 120);
    for (const auto& mark : contrastIn(scene)) marked[std::size_t{mark.row} * 160 + mark.column] = true;
    std::size_t changed = 0;
    for (std::size_t i = 0; i < marked.size(); ++i) {
        const bool same = std::equal(&with.pixels[4 * i], &with.pixels[4 * i] + 4, &without.pixels[4 * i]);
        changed += same ? 0 : 1;
        ASSERT_TRUE(same || marked[i]) << i;
    }
    EXPECT_GT(changed, 100U);
    EXPECT_EQ(planOf(twoBalls(0.0, 1.3)).surfaces.size() + 1, planOf(scene).surfaces.size());
}

TEST(DepthContrast, OneLayerOrAWireHasNone) {
    auto scene = twoBalls(1.0, 1.3);
    EXPECT_TRUE(contrastsDepth(scene.view));
    std::get<MeshStyle>(scene.view.layers[1].style).set_wire(true);
    EXPECT_FALSE(contrastsDepth(scene.view));
    scene = twoBalls(1.0, 1.3);
    scene.view.layers[0].opacity = 0.0;
    EXPECT_FALSE(contrastsDepth(scene.view));
}

TEST(DepthContrast, IsAFieldOfTheView) {
    proto::View message;
    message.set_width(8);
    message.set_height(8);
    message.set_depth_contrast(0.25);
    const auto view = parseView(message);
    ASSERT_TRUE(view.ok());
    EXPECT_EQ(view->depthContrast, 0.25);
    EXPECT_EQ(toProto(*view).depth_contrast(), 0.25);
    message.set_depth_contrast(1.5);
    ASSERT_FALSE(parseView(message).ok());
    EXPECT_EQ(parseView(message).error().where, "depthContrast");
}

}  // namespace
}  // namespace mote::render
