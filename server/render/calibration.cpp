// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/calibration.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>

#include "server/render/calibration_step.h"

#include "server/render/layers/make_frame_plan.h"

namespace mote::render {
namespace {

constexpr double million = 1e6;

/// The quality of pictures in motion, which is what is to be foretold.
constexpr Quality quality{.resolutionScale = 1.0, .pointFraction = 1.0, .slabs = 24, .samplesPerCell = 1.0};

Scene calibrationScene(const std::shared_ptr<const storage::ParticleStep>& step, double pointFraction) {
    ParticlesStyle style{.volumeOpacity = Curve::constant(0.01),
                         .colorMap = ColorMap::find("inferno").value(),
                         .pointFraction = Curve::constant(pointFraction),
                         .pointOpacity = 0.1,
                         .pointSize = 1.0,
                         .pointColor = glm::dvec3(1.0)};
    View view{.width = 512, .height = 512, .background = glm::dvec3(0.0), .camera = {}, .layers = {}};
    view.camera = fitCamera(plotBounds, view.aspect());
    view.layers.push_back({.dataset = {}, .style = std::move(style)});
    return {std::move(view), {step}};
}

/// The quickest of a few pictures, ms: the first ones upload, and a machine may be busy.
double quickest(Device& device, const Scene& scene) {
    constexpr int pictures = 4;
    SelectionCache selections;
    double best = std::numeric_limits<double>::infinity();
    for (int i = 0; i < pictures; ++i) {
        const auto plan = makeFramePlan(scene, quality, selections, device.abilities());
        const auto begun = std::chrono::steady_clock::now();
        device.render(plan, PixelFormat::srgb8, {});
        const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begun;
        best = std::min(best, taken.count());
    }
    return best;
}

}  // namespace

double pixelWork(const Quality& quality) {
    const Quality exact = Quality::exact();
    return 0.5 * quality.samplesPerCell / exact.samplesPerCell +
           0.5 * static_cast<double>(quality.slabs) / exact.slabs;
}

DeviceCosts calibrate(Device& device) {
    const auto step = std::make_shared<const CalibrationStep>();
    const auto without = calibrationScene(step, 0.0);
    const double pixelMs = quickest(device, without);
    const double allMs = quickest(device, calibrationScene(step, 1.0));
    const double pixels = static_cast<double>(without.view.width) * without.view.height / million;
    // Never nothing: what cannot be told apart from the clock's grain costs something in larger pictures.
    constexpr double least = 0.1;
    return {std::max((allMs - pixelMs) / (static_cast<double>(step->pointCount()) / million), least),
            std::max(pixelMs / (pixels * pixelWork(quality)), least)};
}

}  // namespace mote::render
