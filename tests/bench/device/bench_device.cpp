// SPDX-License-Identifier: GPL-3.0-or-later
//
// bench-device: what one picture costs on a device, from plan to RGBA, on an orbit of ten degrees a picture,
// as one JSON object. With --export it writes the scene for another program instead; tests/bench/compare and
// tests/bench/growth make tables of it.
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <map>

#include "server/render/cpu/cpu_device.h"
#include "server/render/device.h"
#include "server/render/layers/make_frame_plan.h"
#include "tests/bench/device/bench_scene.h"
#include "tests/bench/device/scene_export.h"
#include "tests/golden/comparison.h"
#include "tests/reference/reference_renderer.h"

namespace mote::bench {
namespace {

struct Options {
    SceneOptions scene;
    render::Quality quality = render::Quality::exact();
    std::string device = "cpu";
    unsigned threads = 0;
    int frames = 9;
    std::uint32_t reference = 0;  ///< width of a picture that is held against the reference; 0: none
    std::string png, exportTo;
};

struct Times {
    std::vector<double> plan, all;  ///< ms

    static double median(std::vector<double> values) {
        std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                         values.end());
        return values[values.size() / 2];
    }
};

double since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

test::Image imageOf(render::Picture picture) {
    return {picture.width, picture.height, std::move(picture.pixels)};
}

test::Image draw(render::Device& device, const render::Scene& scene, const render::Quality& quality) {
    return imageOf(*device.render(render::makeFramePlan(scene, quality), render::PixelFormat::srgb8, {}));
}

/// As a session does it: what does not depend on the camera is selected once.
struct Run {
    Times times;
    double firstMs = 0.0;  ///< the first picture, with all that is kept for the next
    render::Picture picture;
};

Run run(render::Device& device, render::Scene scene, const Options& options) {
    render::SelectionCache selections;
    const auto eyes = orbitOf(scene.view.camera, options.frames + 1);
    Run made;
    for (std::size_t i = 0; i < eyes.size(); ++i) {
        scene.view.camera.eye = eyes[i];
        const auto start = std::chrono::steady_clock::now();
        const auto plan = render::makeFramePlan(scene, options.quality, selections, device.abilities());
        const double planMs = since(start);
        auto picture = device.render(plan, render::PixelFormat::srgb8, {});
        const double ms = since(start);
        if (i == 0) {
            made.firstMs = ms;
            made.picture = *std::move(picture);
        } else {
            made.times.plan.push_back(planMs);
            made.times.all.push_back(ms);
        }
    }
    return made;
}

struct Light {
    double lit = 0.0;   ///< share of the pixels that are not black
    double mean = 0.0;  ///< of all channels, of 255
};

Light lightOf(const test::Image& image) {
    Light light;
    const std::size_t pixels = image.pixels.size() / 4;
    for (std::size_t i = 0; i < pixels; ++i) {
        const auto* p = &image.pixels[4 * i];
        light.lit += p[0] + p[1] + p[2] > 0 ? 1.0 : 0.0;
        light.mean += (p[0] + p[1] + p[2]) / 3.0;
    }
    return {light.lit / static_cast<double>(pixels), light.mean / static_cast<double>(pixels)};
}

/// ", ..." of how near the picture comes to the reference, at the width that is asked for.
std::string nearness(render::Device& device, const render::Scene& scene, const Options& options) {
    if (options.reference == 0) return {};
    render::Scene small = scene;
    small.view.width = options.reference;
    small.view.height = std::max(1U, options.reference * scene.view.height / scene.view.width);
    const auto exact = reference::render(small);
    const auto near =
        test::compare(draw(device, small, options.quality), reference::encode(exact), exact.ambiguous);
    return fmt::format(R"(, "psnr": {:.2f}, "closeShare": {:.6f}, "worst": {}, "referenceWidth": {})",
                       std::min(near.psnr, 999.0), near.closeShare, near.worst, options.reference);
}

/// Of the arrays that the cpu device reads of each leaf: its cell, its count and how many are drawn.
constexpr double bytesOfLeaf = 8 + 4 + 4;

int measure(const render::Scene& scene, const Options& options) {
    const auto kind = render::parseDeviceKind(options.device).value();
    const auto device = kind == render::DeviceKind::cpu && options.threads > 0
                            ? std::make_unique<render::CpuDevice>(render::CpuOptions{options.threads})
                            : render::createDevice(kind);
    auto made = run(*device, scene, options);
    const auto& step = *scene.layers[0].step;
    const auto points = static_cast<double>(step.pointCount());
    const double bytes = points > 0.0 ? sizeof(storage::PackedPosition) +
                                            bytesOfLeaf * static_cast<double>(step.leaves().size()) / points
                                      : 0.0;
    const std::uint64_t drawn = made.picture.pointsDrawn;
    const auto image = imageOf(std::move(made.picture));
    if (!options.png.empty()) {
        const auto written = test::writePng(image, options.png);
        if (!written.ok()) fmt::print(stderr, "bench-device: {}\n", written.error().toString());
    }
    const Light light = lightOf(image);
    fmt::print(
        R"({{"device": "{}", "firstMs": {:.3f}, "planMs": {:.3f}, "ms": {:.3f}, "fastestMs": {:.3f}, )"
        R"("frames": {}, "pointsDrawn": {}, "bytesPerPoint": {:.3f}, "lit": {:.4f}, "mean": {:.2f}{}}})"
        "\n",
        device->name(), made.firstMs, Times::median(made.times.plan), Times::median(made.times.all),
        *std::min_element(made.times.all.begin(), made.times.all.end()), options.frames, drawn, bytes,
        light.lit, light.mean, nearness(*device, scene, options));
    return 0;
}

void addOptions(CLI::App& app, Options& options) {
    const std::map<std::string, Shown> kinds{{"points", Shown::points},
                                             {"volume", Shown::volume},
                                             {"hybrid", Shown::hybrid},
                                             {"default", Shown::unsaid}};
    app.add_option("--show", options.scene.shown,
                   "points, volume, hybrid or default: the style of a view "
                   "that says none")
        ->transform(CLI::CheckedTransformer(kinds));
    app.add_option("--data", options.scene.data, "beam:PARTICLES, ball:LEVEL or the folder of a dataset");
    app.add_option("--width", options.scene.width, "pixels")->check(CLI::Range(16, 8192));
    app.add_option("--height", options.scene.height, "pixels")->check(CLI::Range(16, 4096));
    app.add_option("--opacity", options.scene.opacity, "of a point")->check(CLI::Range(0.0, 0.9999));
    app.add_option("--point-size", options.scene.pointSize, "pixels")->check(CLI::Range(0.1, 64.0));
    app.add_option("--color-by", options.scene.colorBy, "mean or nearest, of values of the points")
        ->check(CLI::IsMember({"mean", "nearest"}));
    app.add_flag("--filling", options.scene.filling, "from so near that the data fill the window");
    app.add_option("--slabs", options.quality.slabs, "of depth")->check(CLI::Range(1, 1024));
    app.add_option("--samples", options.quality.samplesPerCell, "of the volume, a cell's edge")
        ->check(CLI::Range(0.1, 64.0));
    app.add_option("--device", options.device, "cpu, egl or auto")
        ->check(CLI::IsMember({"cpu", "egl", "auto"}));
    app.add_option("--threads", options.threads, "of plan and cpu device; default all")
        ->check(CLI::Range(1, 1024));
    app.add_option("--frames", options.frames, "measured ones, one more comes first")
        ->check(CLI::Range(1, 100000));
    app.add_option("--reference", options.reference, "also PSNR against the reference, at this width")
        ->check(CLI::Range(16, 4096));
    app.add_option("--png", options.png, "keeps the first picture");
    app.add_option("--export", options.exportTo, "writes the scene into this folder and measures nothing");
}

int runWith(const Options& options) {
    std::optional<oneapi::tbb::global_control> limit;
    if (options.threads > 0) {
        limit.emplace(oneapi::tbb::global_control::max_allowed_parallelism, options.threads);
    }
    const auto scene = makeScene(options.scene);
    if (!scene.ok()) {
        fmt::print(stderr, "bench-device: {}\n", scene.error().toString());
        return 1;
    }
    if (options.exportTo.empty()) return measure(*scene, options);
    const auto eyes = orbitOf(scene->view.camera, options.frames + 1);
    const auto written = exportScene(*scene, eyes, options.exportTo);
    if (!written.ok()) fmt::print(stderr, "bench-device: {}\n", written.error().toString());
    return written.ok() ? 0 : 1;
}

}  // namespace
}  // namespace mote::bench

int main(int argc, char** argv) {
    mote::bench::Options options;
    CLI::App app("What one picture costs on a device; prints one JSON object");
    mote::bench::addOptions(app, options);
    CLI11_PARSE(app, argc, argv);
    try {
        return mote::bench::runWith(options);
    } catch (const std::exception& failure) {
        fmt::print(stderr, "bench-device: {}\n", failure.what());
        return 1;
    }
}
