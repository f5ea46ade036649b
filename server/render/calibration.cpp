// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/calibration.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <random>

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
    view.layers.push_back({.dataset = {}, .style = proto::ParticlesStyle()});
    Scene scene{std::move(view)};
    scene.layers.push_back({.step = step, .particles = std::move(style)});
    return scene;
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

CalibrationStep::CalibrationStep() {
    addNodes();
    addLeaves();
    positions_.resize(leafNode_.size() * leafPoints);
    std::minstd_rand random;
    const auto place = [&] { return static_cast<std::uint16_t>(random() >> 8); };
    for (auto& position : positions_) position = {place(), place(), place()};
    rows_.resize(positions_.size());
    std::iota(rows_.begin(), rows_.end(), std::uint64_t{0});
    // Log densities that rise from one corner of the box to the opposite one.
    for (std::uint32_t z = 0; z < volumeEdge; ++z) {
        for (std::uint32_t y = 0; y < volumeEdge; ++y) {
            for (std::uint32_t x = 0; x < volumeEdge; ++x) {
                volume_.push_back(std::pow(10.0F, 6.0F * static_cast<float>(x + y + z) / (3 * volumeEdge)));
            }
        }
    }
}

/// All cells of all levels down to that of the leaves, breadth first.
void CalibrationStep::addNodes() {
    const std::uint64_t leaves = std::uint64_t{1} << (3 * level);
    for (std::uint8_t l = 0; l <= level; ++l) {
        const std::uint64_t cells = std::uint64_t{1} << (3 * l);
        const std::size_t next = level_.size() + cells;
        for (std::uint64_t morton = 0; morton < cells; ++morton) {
            level_.push_back(l);
            morton_.push_back(morton);
            childCount_.push_back(l == level ? 0 : 8);
            firstChild_.push_back(static_cast<std::uint32_t>(l == level ? morton : next + 8 * morton));
            count_.push_back(leaves / cells * leafPoints);
            density_.push_back(1.0F);
        }
    }
}

void CalibrationStep::addLeaves() {
    const std::uint32_t leaves = 1U << (3 * level);
    const auto first = static_cast<std::uint32_t>(level_.size()) - leaves;
    for (std::uint32_t i = 0; i < leaves; ++i) {
        leafNode_.push_back(first + i);
        leafBegin_.push_back(std::uint64_t{i} * leafPoints);
        leafCount_.push_back(leafPoints);
        leafDensity_.push_back(1.0F);
    }
}

storage::OctreeNodes CalibrationStep::nodes() const {
    return {level_, morton_, firstChild_, childCount_, count_, density_, density_};
}

storage::Leaves CalibrationStep::leaves() const {
    return {leafNode_, leafBegin_, leafCount_, leafDensity_};
}

std::span<const storage::PackedPosition> CalibrationStep::positions(std::uint64_t begin,
                                                                    std::uint64_t count) const {
    return std::span(positions_).subspan(begin, count);
}

std::span<const std::uint64_t> CalibrationStep::rows(std::uint64_t begin, std::uint64_t count) const {
    return std::span(rows_).subspan(begin, count);
}

}  // namespace mote::render
