// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a volume costs on the cpu device, beside how near the picture comes: time a frame and PSNR. The volume
// is the one that ../shared/peers/gen_volume.py gives to ParaView, with about ParaView's default opacity.
//   bench-cpu-volume [THREADS]     default: all
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>

#include "server/render/cpu/cpu_device.h"
#include "server/render/layers/make_frame_plan.h"
#include "server/render/plan/ray_map.h"
#include "server/render/plan/screen_map.h"
#include "tests/golden/comparison.h"
#include "tests/reference/reference_renderer.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::bench {
namespace {

constexpr int repeats = 7;

/// A smooth ball with detail, t from 0 to 1.
std::shared_ptr<const storage::ParticleStep> ball(std::uint8_t level) {
    const LogDensity scale{1.0, std::exp(10.0)};
    const std::uint32_t size = 1U << level;
    std::vector<float> density;
    density.reserve(std::size_t{size} * size * size);
    const auto place = [size](std::uint32_t i) { return 2.0 * i / (size - 1.0) - 1.0; };
    for (std::uint32_t k = 0; k < size; ++k) {
        for (std::uint32_t j = 0; j < size; ++j) {
            for (std::uint32_t i = 0; i < size; ++i) {
                const double x = place(i), y = place(j), z = place(k);
                const double detail = 0.75 + 0.25 * std::sin(20.0 * x) * std::cos(20.0 * y) +
                                      0.15 * std::sin(90.0 * x) * std::sin(80.0 * y) * std::sin(70.0 * z);
                const double value = std::exp(-6.0 * (x * x + y * y + z * z)) * detail;
                density.push_back(
                    static_cast<float>(std::exp(10.0 * std::floor(255.0 * std::min(value, 1.0)) / 255.0)));
            }
        }
    }
    return test::MemoryStep::make({}, {.volumeLevel = level, .logDensity = scale, .volume = density});
}

render::Scene sceneOf(std::shared_ptr<const storage::ParticleStep> step, bool filling, std::uint32_t width) {
    auto view = test::viewOf(
        "{'width': 16, 'height': 9, 'camera': {'eye': [2.2, 2.0, 6], 'target': [0, 0, 0], 'fovYDegrees': 30},"
        "'layers': [{'particles': {'volume': {'curve': [{'density': 0, 'opacity': 0}, {'density': 0.25, "
        "'opacity': 0.49}, {'density': 0.5, 'opacity': 0.8}, {'density': 1, 'opacity': 1}]},"
        "'points': {'linked': false, 'curve': [{'density': 0, 'fraction': 0}]}}}]}");
    view.width = width;
    view.height = width * 9 / 16;
    if (filling) view.camera.eye *= 0.36;
    return {view, {std::move(step)}};
}

test::Image imageOf(render::Device& device, const render::Scene& scene, const render::Quality& quality) {
    auto picture = device.render(render::makeFramePlan(scene, quality), render::PixelFormat::srgb8, {});
    return {picture->width, picture->height, std::move(picture->pixels)};
}

double medianMilliseconds(render::Device& device, const render::Scene& scene,
                          const render::Quality& quality) {
    const auto plan = render::makeFramePlan(scene, quality);
    std::vector<double> times;
    for (int i = 0; i <= repeats; ++i) {
        const auto start = std::chrono::steady_clock::now();
        device.render(plan, render::PixelFormat::srgb8, {});
        times.push_back(
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    times.erase(times.begin());  // packs the volume
    std::nth_element(times.begin(), times.begin() + repeats / 2, times.end());
    return times[repeats / 2];
}

/// Samples, in millions, that the rays within the box would take if nothing were skipped.
double millionSamples(const render::Scene& scene, const render::Quality& quality) {
    const auto plan = render::makeFramePlan(scene, quality);
    const render::RayMap rays(plan, plan.fields[0].boxToEye, plan.nearDepth,
                              (plan.farDepth - plan.nearDepth) / plan.slabs);
    const double half = plan.camera.halfHeight();
    double cells = 0.0;
    for (std::uint32_t y = 2; y < plan.height; y += 4) {
        for (std::uint32_t x = 2; x < plan.width; x += 4) {
            const double right = (2.0 * (x + 0.5) / plan.width - 1.0) * half * plan.width / plan.height;
            const double up = (1.0 - 2.0 * (y + 0.5) / plan.height) * half;
            const glm::dvec3 origin = rays.entry[0] + right * rays.entry[1] + up * rays.entry[2];
            const glm::dvec3 speed = rays.advance[0] + right * rays.advance[1] + up * rays.advance[2];
            double enter = 0.0, leave = plan.slabs;
            for (int axis = 0; axis < 3; ++axis) {
                const double one = -origin[axis] / speed[axis], other = (1.0 - origin[axis]) / speed[axis];
                enter = std::max(enter, std::min(one, other));
                leave = std::min(leave, std::max(one, other));
            }
            cells += 16.0 * std::max(0.0, leave - enter) * glm::length(speed);
        }
    }
    return cells * scene.steps[0]->volumeSize() * quality.samplesPerCell * 1e-6;
}

void measure(render::Device& device, const std::shared_ptr<const storage::ParticleStep>& step, bool filling) {
    const auto scene = sceneOf(step, filling, 1280);
    const auto small = sceneOf(step, filling, 240);
    const auto exact = reference::encode(reference::render(small, {16.0}));
    for (const double samples : {1.0, 2.0, 4.0}) {
        render::Quality quality = render::Quality::exact();
        quality.samplesPerCell = samples;
        const double ms = medianMilliseconds(device, scene, quality);
        const double million = millionSamples(scene, quality);
        const auto near = test::compare(imageOf(device, small, quality), exact);
        fmt::print("{:4}^3 {:8} {:4.0f} {:10.1f} {:12.0f} {:14.0f} {:10.1f} {:10.3f}\n", step->volumeSize(),
                   filling ? "filling" : "framed", samples, ms, million, million / ms * 1e3, near.psnr,
                   100.0 * near.closeShare);
    }
}

}  // namespace
}  // namespace mote::bench

int main(int count, char** arguments) {
    const unsigned threads = count > 1 ? static_cast<unsigned>(std::atoi(arguments[1])) : 0;
    mote::render::CpuDevice device({.threads = threads});
    fmt::print(
        "{}, 1280 x 720; samples: along all rays within the box, skipped ones too;\n"
        "PSNR against the reference at 240 x 135\n",
        device.name());
    fmt::print("{:6} {:8} {:>4} {:>10} {:>12} {:>14} {:>10} {:>10}\n", "volume", "view", "/cell", "ms",
               "M samples", "M samples/s", "PSNR dB", "% close");
    for (const std::uint8_t level : {6, 7, 8}) {
        const auto step = mote::bench::ball(level);
        for (const bool filling : {false, true}) mote::bench::measure(device, step, filling);
    }
    return 0;
}
