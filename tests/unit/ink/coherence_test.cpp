// SPDX-License-Identifier: GPL-3.0-or-later
//
// Drawings that follow one another: what stays, stays; what moves, moves with the surface.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <thread>

#include "server/render/layers/ink/lower_ink.h"
#include "tests/support/generated_mesh.h"
#include "tests/unit/ink/ink_cover.h"
#include "tests/unit/ink/ink_views.h"

namespace mote::render {
namespace {

constexpr std::uint32_t side = 160;

/// Leaves: many quads in a ball, each with borders all around.
std::shared_ptr<const MeshSurface> leaves(test::Random& random) {
    storage::SurfaceMesh mesh;
    Bounds bounds{glm::dvec3(-1.2), glm::dvec3(1.2)};
    for (std::uint32_t i = 0; i < 1500; ++i) {
        const glm::dvec3 middle = std::cbrt(random.between(0.0, 1.0)) * random.direction();
        const glm::dvec3 normal = random.direction();
        const glm::dvec3 right = 0.06 * glm::normalize(glm::cross(normal, random.direction()));
        const glm::dvec3 up = glm::cross(normal, right);
        for (const auto& at : {-right - up, right - up, right + up, up - right}) {
            mesh.positions.emplace_back(middle + at);
            mesh.normals.emplace_back(normal);
        }
        mesh.triangles.push_back({4 * i, 4 * i + 1, 4 * i + 2});
        mesh.triangles.push_back({4 * i, 4 * i + 2, 4 * i + 3});
    }
    mesh.edges = test::edgesOf(mesh);
    return std::make_shared<const MeshSurface>(std::move(mesh), bounds);
}

Camera turned(double degrees) {
    const double angle = glm::radians(degrees);
    Camera camera;
    camera.eye = {8.0 * std::sin(angle), 0.5, 8.0 * std::cos(angle)};
    camera.target = glm::dvec3(0.0);
    camera.up = {0.0, 1.0, 0.0};
    camera.fovYDegrees = 20.0;
    return camera;
}

InkStyle styleOf(double hatches) {
    auto style = test::usualInk();
    style.hatch.strength = hatches;
    style.coherent = true;
    return style;
}

Strokes drawn(const InkData& surface, const InkStyle& style, const Camera& camera, InkMemory* memory,
              const glm::dmat4& transform = glm::dmat4(1.0)) {
    const Layer layer{.dataset = "data/a", .transform = transform, .style = proto::InkStyle()};
    return inkOf(layer, style, surface, test::planOf(camera, side, side), 1.0, {}, memory).strokes;
}

/// The share of the ink that two pictures do not share.
double difference(const Strokes& a, const Strokes& b) {
    const auto one = test::coverOf(a, side, side), other = test::coverOf(b, side, side);
    double off = 0.0, ink = 0.0;
    for (std::size_t i = 0; i < one.values.size(); ++i) {
        off += std::abs(one.values[i] - other.values[i]);
        ink += 0.5 * (one.values[i] + other.values[i]);
    }
    return off / ink;
}

/// Of films of turns by so small an angle that nothing but the drawing changes.
double flicker(const InkData& surface, const InkStyle& style, bool coherent) {
    InkMemory memory;
    Strokes before;
    double sum = 0.0;
    for (int frame = 0; frame < 6; ++frame) {
        const auto now = drawn(surface, style, turned(0.1 * frame), coherent ? &memory : nullptr);
        if (frame > 0) sum += difference(before, now);
        before = now;
    }
    return sum / 5.0;
}

TEST(Coherence, LinesAndHatchesStay) {
    for (int seed = 0; seed < 2; ++seed) {
        test::Random random(static_cast<std::uint64_t>(seed));
        const auto surface = leaves(random);
        for (const double hatches : {0.0, 1.0}) {
            const auto style = styleOf(hatches);
            const double still = flicker(surface, style, false), film = flicker(surface, style, true);
            EXPECT_LT(film, 0.7 * still) << "seed " << seed << ", hatches " << hatches;
            EXPECT_GT(still, 0.02);
        }
    }
}

TEST(Coherence, WhatDoesNotMoveIsDrawnTheSame) {
    test::Random random(7);
    const auto surface = leaves(random);
    InkMemory memory;
    auto before = drawn(surface, styleOf(1.0), turned(0.0), &memory);
    for (int frame = 0; frame < 3; ++frame) {
        auto now = drawn(surface, styleOf(1.0), turned(0.0), &memory);
        EXPECT_LT(difference(before, now), 0.05);
        before = std::move(now);
    }
}

TEST(Coherence, AMovedLayerIsTheSameAsAMovedCamera) {
    test::Random random(8);
    const auto surface = leaves(random);
    InkMemory memory, moved;
    const auto first = drawn(surface, styleOf(1.0), turned(0.0), &memory);
    EXPECT_EQ(first, drawn(surface, styleOf(1.0), turned(0.0), &moved));
    const auto camera = drawn(surface, styleOf(1.0), turned(1.0), &memory);
    const auto turn = glm::rotate(glm::dmat4(1.0), glm::radians(-1.0), glm::dvec3(0.0, 1.0, 0.0));
    const auto layer = drawn(surface, styleOf(1.0), turned(0.0), &moved, turn);
    EXPECT_LT(difference(camera, layer), 0.25);
    EXPECT_GT(difference(first, layer), 0.25);
}

TEST(Coherence, AnyMemoryServesAnyPicture) {
    for (int seed = 0; seed < 20; ++seed) {
        test::Random random(static_cast<std::uint64_t>(seed));
        const auto form = test::meshForms()[static_cast<std::size_t>(seed) % test::meshForms().size()];
        const auto surface = test::meshOf(std::string(form), static_cast<std::uint32_t>(seed), 200);

        InkMemory memory;
        for (int frame = 0; frame < 3; ++frame) {
            const auto camera = test::anyCamera(random, surface->bounds());
            auto style = styleOf(random.oneOf({0.0, 1.0}));
            const auto width = static_cast<std::uint32_t>(random.between(1.0, 60.0)),
                       height = static_cast<std::uint32_t>(random.between(1.0, 60.0));
            const Layer layer{.dataset = "data/a", .style = proto::InkStyle()};
            const auto plan = test::planOf(camera, width, height);
            for (const auto& point : inkOf(layer, style, surface, plan, 1.0, {}, &memory).strokes.points) {
                EXPECT_TRUE(std::isfinite(point.x) && std::isfinite(point.y));
                EXPECT_TRUE(std::isfinite(point.depth));
            }
        }
    }
}

TEST(Coherence, IsTheSameOnAnyNumberOfThreads) {
    test::Random random(9);
    const auto surface = leaves(random);
    const auto film = [&](int threads) {
        Strokes last;
        tbb::task_arena(threads).execute([&] {
            InkMemory memory;
            for (int frame = 0; frame < 3; ++frame)
                last = drawn(surface, styleOf(1.0), turned(frame), &memory);
        });
        return last;
    };
    EXPECT_EQ(film(1), film(4));
}

TEST(Coherence, WhatIsStoppedIsNotRemembered) {
    test::Random random(10);
    const auto surface = leaves(random);
    const auto style = styleOf(1.0);
    const Layer layer{.dataset = "data/a", .style = proto::InkStyle()};
    const auto draw = [&](const std::stop_token& stop, InkMemory& memory) {
        inkOf(layer, style, surface, test::planOf(turned(0.0), side, side), 1.0, stop, &memory);
    };
    std::stop_source before;
    before.request_stop();
    InkMemory memory;
    draw(before.get_token(), memory);
    EXPECT_TRUE(memory.depth.values.empty());
    // At any time of the second drawing.
    draw({}, memory);
    for (int wait = 0; wait < 30; ++wait) {
        std::stop_source source;
        std::thread stopper([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(wait));
            source.request_stop();
        });
        draw(source.get_token(), memory);
        stopper.join();
        EXPECT_FALSE(memory.depth.values.empty());
    }
}

}  // namespace
}  // namespace mote::render
