// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-egl-points [--points N] [--repeat N]: points a second of the egl device against blended GL_POINTS,
// and the device's whole frames, measured in one run on the same points and camera. Prints tables; asserts
// nothing.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "protocol/cli/command.h"
#include "server/render/egl/egl_device.h"
#include "server/render/layers/make_frame_plan.h"
#include "server/render/plan/octree_cell.h"
#include "tests/bench/bench_step.h"
#include "tests/bench/gl_points.h"

namespace mote::bench {
namespace {

using render::StageTimes;

constexpr std::uint32_t width = 1280;
constexpr std::uint32_t height = 720;

struct Frame {
    double plan = 0.0;   ///< ms
    double total = 0.0;  ///< ms, plan and read-back included
    StageTimes stages;
    std::uint64_t points = 0;

    double accumulation() const { return (stages.pointsMark + stages.allocate + stages.pointsAdd).count(); }
};

double milliseconds(std::chrono::steady_clock::time_point since) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - since).count();
}

View viewOf(const Curve& volume, const Curve& points) {
    View view;
    view.width = width;
    view.height = height;
    view.camera = fitCamera({glm::dvec3(-0.6), glm::dvec3(0.6)}, view.aspect());
    view.layers.push_back(
        {"bench/beam", 0, glm::dmat4(1.0),
         ParticlesStyle{volume, ColorMap::standard(), points, 0.5, 1.0, glm::dvec3(1.0, 0.7, 0.3)}});
    return view;
}

Curve rising(double from, double to) {
    return Curve::create({{from, 0.0}, {1.0, to}}).value();
}

/// The quickest of several frames: what the machine can do when others leave it alone.
Frame measure(render::EglDevice& device, const render::Scene& scene, const render::Quality& quality,
              int repeat) {
    Frame best;
    for (int i = -1; i < repeat; ++i) {
        const auto start = std::chrono::steady_clock::now();
        const auto plan = render::makeFramePlan(scene, quality);
        Frame frame;
        frame.plan = milliseconds(start);
        const auto picture = device.render(plan, render::PixelFormat::srgb8, {});
        frame.total = milliseconds(start);
        frame.stages = device.lastTimes();
        frame.points = picture->pointsDrawn;
        if (i == 0 || (i > 0 && frame.total < best.total)) best = frame;  // the first run warms up
    }
    return best;
}

/// Where the points are, in layer space, as a vertex buffer has them.
std::vector<glm::vec3> vertices(const BenchStep& step) {
    const auto leaves = step.leaves();
    const auto nodes = step.nodes();
    std::vector<glm::vec3> points;
    points.reserve(step.pointCount());
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
        const double edge = std::ldexp(1.0, -nodes.level[leaves.node[leaf]]);
        const glm::dvec3 corner = glm::dvec3(render::cellPlace(nodes.morton[leaves.node[leaf]])) * edge;
        for (const auto& p : step.positions(leaves.pointBegin[leaf], leaves.pointCount[leaf])) {
            const glm::dvec3 inside = (glm::dvec3(p.x, p.y, p.z) + 0.5) / 65536.0;
            points.push_back(glm::vec3(2.0 * (corner + edge * inside) - 1.0));
        }
    }
    return points;
}

glm::mat4 toClip(const Camera& camera) {
    return glm::mat4(glm::perspective(glm::radians(camera.fovYDegrees), double{width} / height, 0.01, 100.0) *
                     camera.worldToEye());
}

double quickestPoints(const std::vector<glm::vec3>& points, const Camera& camera, bool over, int repeat) {
    GlPoints baseline(width, height, points, over);
    double best = baseline.draw(toClip(camera));
    for (int i = 0; i < repeat; ++i) best = std::min(best, baseline.draw(toClip(camera)));
    fmt::print("  blended GL_POINTS, {:<22} {:>9.1f} ms {:>9.1f} M/s   ({} pixels touched)\n",
               over ? "over into RGBA8" : "added into RGBA16F", 1e3 * best,
               1e-6 * static_cast<double>(points.size()) / best, baseline.pixelsTouched());
    return best;
}

void comparePoints(render::EglDevice& device, const std::shared_ptr<const BenchStep>& step, int repeat) {
    const render::Scene scene{viewOf(Curve::constant(0.0), Curve::constant(1.0)), {step}};
    fmt::print("\nAll {} points, {} x {}\n", step->pointCount(), width, height);
    const auto points = vertices(*step);
    const double added = quickestPoints(points, scene.view.camera, false, repeat);
    const double over = quickestPoints(points, scene.view.camera, true, repeat);
    const double baseline = std::min(added, over);
    const Frame flat = measure(device, scene, render::Quality::exact(), repeat);
    // A volume too thin to be seen, with which the points must be kept apart by depth.
    const render::Scene mixed{viewOf(Curve::constant(1e-9), Curve::constant(1.0)), {step}};
    const Frame slabs = measure(device, mixed, render::Quality::exact(), repeat);
    const auto row = [&](const char* what, double ms) {
        fmt::print("  compute, {:<31} {:>9.1f} ms {:>9.1f} M/s   {:.1f} times GL_POINTS\n", what, ms,
                   1e-3 * static_cast<double>(flat.points) / ms, 1e3 * baseline / ms);
    };
    row("points alone, accumulated", flat.accumulation());
    row("points alone, whole frame", flat.total);
    row("in slabs, to mix with a volume", slabs.accumulation());
}

void measureFrames(render::EglDevice& device, const std::shared_ptr<const BenchStep>& step, int repeat) {
    const Curve volume = rising(0.3, 0.3);
    const render::Quality exact = render::Quality::exact();
    const render::Quality moving{
        .resolutionScale = 0.5, .pointFraction = 0.25, .slabs = 32, .samplesPerCell = 1.0};
    struct Row {
        const char* name;
        View view;
        render::Quality quality;
    };
    const Row rows[] = {
        {"linked, at rest", viewOf(volume, linkedFraction(volume)), exact},
        {"linked, moving", viewOf(volume, linkedFraction(volume)), moving},
        {"volume, at rest", viewOf(volume, Curve::constant(0.0)), exact},
        {"volume, moving", viewOf(volume, Curve::constant(0.0)), moving},
        {"all points and volume, at rest", viewOf(volume, Curve::constant(1.0)), exact},
        {"all points and volume, moving", viewOf(volume, Curve::constant(1.0)), moving},
    };
    fmt::print(
        "\nFrames of {} x {} (moving: half of it), ms\n  {:<32}{:>8}{:>8}{:>8}{:>8}{:>8}{:>10}{:>8}{:>11}\n",
        width, height, "", "plan", "bricks", "mark", "cells", "add", "composite", "total", "points");
    for (const auto& [name, view, quality] : rows) {
        const Frame f = measure(device, {view, {step}}, quality, repeat);
        fmt::print("  {:<32}{:>8.1f}{:>8.1f}{:>8.1f}{:>8.1f}{:>8.1f}{:>10.1f}{:>8.1f}{:>11}\n", name, f.plan,
                   f.stages.volumeMark.count(), f.stages.pointsMark.count(), f.stages.allocate.count(),
                   f.stages.pointsAdd.count(), f.stages.composite.count(), f.total, f.points);
    }
}

}  // namespace
}  // namespace mote::bench

int main(int argc, char** argv) {
    std::uint64_t points = 4'000'000;
    int repeat = 5;
    const mote::cli::Program commandLine("Points a second and milliseconds a frame of the egl device",
                                         "bench-egl-points");
    const auto app = commandLine.command();
    app.option("--points", points, "particles of the beam").range(1000, 200'000'000);
    app.option("--repeat", repeat, "measured runs of each; the quickest counts").range(1, 1000);
    if (const auto end = commandLine.parse(argc, argv)) return *end;
    const auto step = std::make_shared<const mote::bench::BenchStep>(points, 7, 1);
    mote::render::EglOptions options;
    options.measure = true;
    mote::render::EglDevice device(options);
    fmt::print("{}, {} leaves\n", device.name(), step->leaves().size());
    mote::bench::comparePoints(device, step, repeat);
    mote::bench::measureFrames(device, step, repeat);
}
