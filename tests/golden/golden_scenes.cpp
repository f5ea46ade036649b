// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/golden/golden_scenes.h"

#include <algorithm>
#include <map>

#include "protocol/scene/plot_density.h"
#include "tests/golden/golden_colors.h"
#include "tests/golden/golden_dots.h"
#include "tests/golden/golden_hybrids.h"
#include "tests/support/beams.h"
#include "tests/support/generated_mesh.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::test {
namespace {

std::shared_ptr<const MemoryStep> denseBeam() {
    const BeamShape shape{.core = 80000, .halo = 8000, .filaments = 4000};
    return MemoryStep::make(beam(shape), {.leafCapacity = 64, .maxLevel = 9, .volumeLevel = 6});
}

/// A wide core of uneven weights, coarse leaves and a coarse volume: the seam between points and volume is
/// broad.
std::shared_ptr<const MemoryStep> goldenWideBeam() {
    BeamShape shape{.core = 40000, .halo = 20000, .filaments = 8000};
    shape.coreSigma = 0.12;
    shape.evenWeights = false;
    shape.seed = 2;
    return MemoryStep::make(beam(shape), {.leafCapacity = 128, .maxLevel = 7, .volumeLevel = 5});
}

std::shared_ptr<const MemoryStep> largeBeam() {
    const BeamShape shape{.core = 160000, .halo = 30000, .filaments = 10000, .seed = 3};
    return MemoryStep::make(beam(shape), {.leafCapacity = 100, .maxLevel = 10, .volumeLevel = 6});
}

/// The same squeezed into a tilted sheet that is thicker on one side: its parts are points though they are
/// dense, or volume.
std::shared_ptr<const MemoryStep> sheet() {
    auto points = beam({.core = 160000, .halo = 30000, .filaments = 10000, .seed = 4});
    for (auto& [place, weight] : points) {
        const double across = place.x < 0.5 ? 0.003 : 0.3;
        place.y = std::clamp(0.5 + across * (place.y - 0.5) + 0.3 * (place.x - 0.5), 0.0, 1.0);
    }
    return MemoryStep::make(points, {.leafCapacity = 64, .maxLevel = 10, .volumeLevel = 5});
}

const char* const denseCore = R"({
  'width': 320, 'height': 180,
  'camera': {'eye': [1.2, 0.8, 2], 'target': [0, 0, 0]},
  'layers': [{'particles': {
    'volume': {'curve': [{'density': 0.2, 'opacity': 0}, {'density': 0.5, 'opacity': 0.4},
                         {'density': 1, 'opacity': 0.9}]},
    'points': {'opacity': 1}}}]})";

const char* const haloOnly = R"({
  'width': 320, 'height': 180,
  'camera': {'eye': [-0.6, 1.6, 0.9], 'target': [0, 0, 0]},
  'layers': [{'particles': {
    'volume': {'curve': [{'density': 0, 'opacity': 0}]},
    'points': {'linked': false, 'opacity': 0.7, 'color': [0.6, 0.85, 1],
               'curve': [{'density': 0.5, 'fraction': 1}, {'density': 0.8, 'fraction': 0}]}}}]})";

const char* const linked = R"({
  'width': 480, 'height': 270,
  'layers': [{'particles': {
    'volume': {'curve': [{'density': 0.45, 'opacity': 0}, {'density': 0.75, 'opacity': 0.12},
                         {'density': 1, 'opacity': 0.3}]},
    'points': {'opacity': 0.5}}}]})";

const char* const unlinked = R"({
  'width': 320, 'height': 180,
  'camera': {'eye': [0.9, -1.4, 2.4], 'target': [0, 0, 0]},
  'layers': [{'particles': {
    'volume': {'colorMap': 'viridis',
               'curve': [{'density': 0, 'opacity': 0.02}, {'density': 0.5, 'opacity': 0.08},
                         {'density': 1, 'opacity': 0.3}]},
    'points': {'linked': false, 'opacity': 1, 'color': [1, 0.3, 0.2],
               'curve': [{'density': 0, 'fraction': 1}, {'density': 1, 'fraction': 0.4}]}}}]})";

const char* const zoomedInside = R"({
  'width': 320, 'height': 180,
  'camera': {'eye': [0.3, 0.12, 0.42], 'target': [0, 0, 0], 'fovYDegrees': 60},
  'layers': [{'particles': {
    'volume': {'colorMap': 'plasma', 'curve': [{'density': 0.3, 'opacity': 0}, {'density': 1, 'opacity': 0.12}]},
    'points': {'opacity': 0.8}}}]})";

const char* const orthographic = R"({
  'width': 320, 'height': 180,
  'camera': {'eye': [2, 1, 3], 'target': [0, 0, 0], 'up': [0.2, 1, 0], 'orthographicHeight': 1.5},
  'layers': [{'particles': {
    'volume': {'colorMap': 'magma', 'curve': [{'density': 0.1, 'opacity': 0}, {'density': 1, 'opacity': 0.4}]},
    'points': {'opacity': 1}}}]})";

// The eye stands in the middle of the beam; half of the picture lies behind it.
const char* const orthographicInside = R"({
  'width': 160, 'height': 120,
  'camera': {'eye': [0, 0, 0], 'target': [0.3, 0.1, -1], 'orthographicHeight': 1.2},
  'layers': [{'particles': {
    'volume': {'curve': [{'density': 0.3, 'opacity': 0}, {'density': 1, 'opacity': 0.2}]},
    'points': {'opacity': 0.6}}}]})";

const char* const discs = R"({
  'width': 320, 'height': 180,
  'camera': {'eye': [1.2, 0.8, 2], 'target': [0, 0, 0]},
  'layers': [{'particles': {
    'volume': {'colorMap': 'oslo', 'curve': [{'density': 0.1, 'opacity': 0}, {'density': 0.8, 'opacity': 0.4}]},
    'points': {'opacity': 0.9, 'sizePixels': 3, 'color': [0.9, 1, 0.5]}}}]})";

// The second beam stands across the first, smaller, turned and moved, so that the cores pass through each
// other.
const char* const twoLayers = R"({
  'width': 320, 'height': 180,
  'camera': {'eye': [0.8, 0.9, 2], 'target': [0, 0, 0]},
  'layers': [
    {'particles': {
      'volume': {'curve': [{'density': 0.1, 'opacity': 0}, {'density': 1, 'opacity': 0.35}]},
      'points': {'opacity': 1}}},
    {'transform': [0.1, -0.7, 0, 0.15,  0.6, 0.1, 0.2, 0.05,  0, -0.2, 0.8, 0.1,  0, 0, 0, 1],
     'particles': {
      'volume': {'colorMap': 'viridis', 'curve': [{'density': 0.2, 'opacity': 0}, {'density': 1, 'opacity': 0.3}]},
      'points': {'linked': false, 'opacity': 0.8, 'sizePixels': 2, 'color': [0.4, 0.8, 1],
                 'curve': [{'density': 0.1, 'fraction': 1}, {'density': 0.5, 'fraction': 0.05}]}}}]})";

const char* const whiteBackground = R"({
  'width': 320, 'height': 180, 'background': [1, 1, 1],
  'camera': {'eye': [-1.5, 1, 2.3], 'target': [0, 0, 0]},
  'layers': [{'particles': {
    'volume': {'colorMap': 'cividis', 'curve': [{'density': 0.3, 'opacity': 0}, {'density': 1, 'opacity': 0.4}]},
    'points': {'opacity': 0.9, 'sizePixels': 0.7, 'color': [0.1, 0.1, 0.4]}}}]})";

// Transfer functions with steps: shells of density, and points from some density on.
const char* const steps = R"({
  'width': 320, 'height': 180, 'background': [0.1, 0.1, 0.1],
  'camera': {'eye': [1.2, 0.8, 2.3], 'target': [0, 0, 0]},
  'layers': [{'particles': {
    'volume': {'colorMap': 'turbo',
               'curve': [{'density': 0.4, 'opacity': 0}, {'density': 0.4, 'opacity': 0.05},
                         {'density': 0.5, 'opacity': 0.05}, {'density': 0.5, 'opacity': 0},
                         {'density': 0.75, 'opacity': 0}, {'density': 0.75, 'opacity': 0.2}]},
    'points': {'linked': false, 'opacity': 0.8,
               'curve': [{'density': 0.2, 'fraction': 0}, {'density': 0.2, 'fraction': 0.7},
                         {'density': 0.6, 'fraction': 0.7}, {'density': 0.6, 'fraction': 0}]}}}]})";

// A world in metres, a beam of half a millimetre, a kilometre from the origin.
const char* const farAway = R"({
  'width': 320, 'height': 180,
  'camera': {'eye': [1000.0006, 0.0004, 0.0008], 'target': [1000, 0, 0]},
  'layers': [{'transform': [0.0005, 0, 0, 1000,  0, 0.0005, 0, 0,  0, 0, 0.0005, 0,  0, 0, 0, 1],
    'particles': {
    'volume': {'curve': [{'density': 0.2, 'opacity': 0}, {'density': 1, 'opacity': 0.3}]},
    'points': {'opacity': 0.9}}}]})";

const char* const onePixel = R"({
  'width': 1, 'height': 1, 'background': [0.2, 0.4, 0.6],
  'camera': {'eye': [1, 1, 3], 'target': [0, 0, 0], 'fovYDegrees': 2},
  'layers': [{'particles': {
    'volume': {'curve': [{'density': 0.3, 'opacity': 0}, {'density': 1, 'opacity': 0.05}]},
    'points': {'opacity': 0.01}}}]})";

const char* const oddSize = R"({
  'width': 17, 'height': 5, 'background': [0.2, 0.4, 0.6],
  'camera': {'eye': [1, 1, 3], 'target': [0, 0, 0], 'fovYDegrees': 25},
  'layers': [{'particles': {
    'volume': {'curve': [{'density': 0.3, 'opacity': 0}, {'density': 1, 'opacity': 0.1}]},
    'points': {'opacity': 0.005, 'sizePixels': 1.5}}}]})";

const char* const tallAndNarrow = R"({
  'width': 3, 'height': 257,
  'camera': {'eye': [0, 0, 3], 'target': [0, 0, 0]},
  'layers': [{'particles': {
    'volume': {'curve': [{'density': 0.3, 'opacity': 0}, {'density': 1, 'opacity': 0.2}]},
    'points': {'opacity': 0.6, 'sizePixels': 9}}}]})";

// A shell of dots around the beam: in front of it and behind it.
const char* const dotShell = R"({
  'width': 320, 'height': 180,
  'camera': {'eye': [1.2, 0.8, 2], 'target': [0, 0, 0]},
  'layers': [{'particles': {
    'volume': {'curve': [{'density': 0.1, 'opacity': 0}, {'density': 0.6, 'opacity': 0.2}]},
    'points': {'linked': false, 'opacity': 0.8,
               'curve': [{'density': 0, 'fraction': 1}, {'density': 1, 'fraction': 0.4}]}}}]})";

// A plane of dots cuts through the cores of two beams.
const char* const dotPlane = R"({
  'width': 320, 'height': 180, 'background': [0.1, 0.2, 0.1],
  'camera': {'eye': [0.8, 0.9, 2], 'target': [0, 0, 0]},
  'layers': [
    {'particles': {
      'volume': {'curve': [{'density': 0.1, 'opacity': 0}, {'density': 1, 'opacity': 0.25}]},
      'points': {'opacity': 0.9, 'sizePixels': 2}}},
    {'transform': [0.1, -0.7, 0, 0.15,  0.6, 0.1, 0.2, 0.05,  0, -0.2, 0.8, 0.1,  0, 0, 0, 1],
     'particles': {
      'volume': {'curve': [{'density': 0.2, 'opacity': 0}, {'density': 1, 'opacity': 0.2}]},
      'points': {'opacity': 0.5}}}]})";

const char* const dotBackdrop = R"({
  'width': 320, 'height': 180, 'background': [1, 1, 1],
  'camera': {'eye': [-1.5, 1, 2.3], 'target': [0, 0, 0], 'orthographicHeight': 2.2},
  'layers': [{'particles': {
    'volume': {'colorMap': 'cividis', 'curve': [{'density': 0.3, 'opacity': 0}, {'density': 1, 'opacity': 0.4}]},
    'points': {'opacity': 0.9, 'color': [0.1, 0.1, 0.4]}}}]})";

// Dots and points without any volume.
const char* const dotsAndPoints = R"({
  'width': 320, 'height': 180,
  'camera': {'eye': [-0.6, 1.6, 0.9], 'target': [0, 0, 0]},
  'layers': [{'particles': {
    'volume': {'curve': [{'density': 0, 'opacity': 0}]},
    'points': {'linked': false, 'opacity': 0.7, 'color': [0.6, 0.85, 1],
               'curve': [{'density': 0.5, 'fraction': 1}, {'density': 0.8, 'fraction': 0}]}}}]})";

const char* const dotsAlone = R"({
  'width': 199, 'height': 101, 'background': [1, 0.98, 0.9],
  'camera': {'eye': [1.2, 0.8, 2], 'target': [0, 0, 0]}})";

/// A ball around the beam, seen through.
const char* const meshShell = R"({
  'width': 320, 'height': 180, 'background': [1, 1, 1],
  'camera': {'eye': [-0.6, 1.6, 1.9], 'target': [0, 0, 0]},
  'layers': [{'particles': {'points': {'opacity': 0.8, 'color': [0.1, 0.1, 0.4]}}},
             {'mesh': {'color': [0.9, 0.6, 0.3], 'opacity': 0.4, 'light': {'specular': 0.5}}}]})";

/// All is left to the plot (docs/PICTURE.md, "What a view leaves out").
const char* const byPlot = R"({
  'width': 320, 'height': 180,
  'camera': {'eye': [0.9, 1.3, 2.1], 'target': [0, 0, 0]},
  'layers': [{'particles': {}}]})";

struct Recipe {
    const char* view;
    std::vector<std::shared_ptr<const MemoryStep> (*)()> steps;
    DotsOf dots = nullptr;
    const char* mesh = nullptr;  ///< of the last layer, which has no step
};

const std::map<std::string, Recipe>& recipes() {
    static const std::map<std::string, Recipe> all{
        {"denseCore", {denseCore, {denseBeam}}},
        {"haloOnly", {haloOnly, {largeBeam}}},
        {"linked", {linked, {largeBeam}}},
        {"unlinked", {unlinked, {goldenWideBeam}}},
        {"zoomedInside", {zoomedInside, {largeBeam}}},
        {"orthographic", {orthographic, {denseBeam}}},
        {"orthographicInside", {orthographicInside, {goldenWideBeam}}},
        {"discs", {discs, {denseBeam}}},
        {"twoLayers", {twoLayers, {denseBeam, goldenWideBeam}}},
        {"whiteBackground", {whiteBackground, {goldenWideBeam}}},
        {"steps", {steps, {goldenWideBeam}}},
        {"farAway", {farAway, {denseBeam}}},
        {"onePixel", {onePixel, {denseBeam}}},
        {"oddSize", {oddSize, {goldenWideBeam}}},
        {"tallAndNarrow", {tallAndNarrow, {goldenWideBeam}}},
        {"dotShell", {dotShell, {denseBeam}, dotsAround}},
        {"dotPlane", {dotPlane, {denseBeam, goldenWideBeam}, dotsThrough}},
        {"dotBackdrop", {dotBackdrop, {goldenWideBeam}, dotsWithoutDepth}},
        {"dotsAndPoints", {dotsAndPoints, {largeBeam}, dotsAround}},
        {"dotsAlone", {dotsAlone, {}, dotsThrough}},
        {"meshShell", {meshShell, {denseBeam}, nullptr, "sphere"}},
        {"byPlot", {byPlot, {largeBeam}}},
        {"sheet", {byPlot, {sheet}}},
    };
    return all;
}

/// A run of this step alone.
PlotDensity plotOf(const storage::ParticleStep& step) {
    const auto points = static_cast<double>(step.pointCount());
    return {step.logDensity(), step.pointCount(), step.nodes().density[0] / points};
}

}  // namespace

const std::vector<GoldenScene>& goldenScenes() {
    // The shares are about two thirds of what the scenes show. With 16 samples a cell the reference differs
    // from itself with 128 by 1/255 at most (67 dB and more); where an opacity jumps, only the first order is
    // left, and it takes 128 samples to come as close; a ray that grazes a shell between two samples misses
    // it.
    static const std::vector<GoldenScene> all{
        {"denseCore", 0.25, 0.25, 0.02},
        {"haloOnly", 0.2, 0.0, 0.2},
        {"linked", 0.05, 0.04, 0.04},
        {"unlinked", 0.35, 0.35, 0.15},
        {"zoomedInside", 0.7, 0.7, 0.1},
        {"orthographic", 0.25, 0.25, 0.04},
        {"orthographicInside", 0.6, 0.6, 0.35},
        {"discs", 0.25, 0.25, 0.1},
        // Points of one beam lie within the other's core: in one pixel of `egl` the order within a slab is
        // wrong by 24 of 255. With four times as many slabs it is 1.
        {"twoLayers", 0.3, 0.3, 0.07, {50.0, 0.999, 32}},
        {"whiteBackground", 0.25, 0.25, 0.065},
        {"steps", 0.25, 0.25, 0.04, {50.0, 0.98, 60}, 0.0, 128.0},
        {"farAway", 0.3, 0.3, 0.07},
        {"onePixel", 1.0, 1.0, 1.0},
        {"oddSize", 0.3, 0.14, 0.3},
        {"tallAndNarrow", 0.5, 0.4, 0.27},
        {"dotShell", 0.3, 0.1, 0.09, {}, 0.05},
        {"dotPlane", 0.4, 0.1, 0.1, {}, 0.15},
        {"dotBackdrop", 0.3, 0.1, 0.05, {}, 0.15},
        {"dotsAndPoints", 0.2, 0.0, 0.1, {}, 0.05},
        {"dotsAlone", 0.2, 0.0, 0.0, {}, 0.2},
        // What of the surface a pixel holds stands at one depth: a point may lie before some of it.
        {"meshShell", 0.3, 0.1, 0.02, {50.0, 0.999, 32}, 0.0, 16.0, 0.25},
        {"byPlot", 0.2, 0.04, 0.1},
        {"sheet", 0.1, 0.02, 0.05},
    };
    return all;
}

render::Scene makeScene(const std::string& name) {
    const auto found = recipes().find(name);
    if (found == recipes().end()) {
        auto colored = makeColoredScene(name);
        return colored ? *std::move(colored) : makeHybridScene(name);
    }
    render::Scene scene{viewOf(found->second.view), {}};
    for (const auto make : found->second.steps) scene.steps.push_back(make());
    if (found->second.view == byPlot)
        resolveByPlot(*scene.view.layers[0].particles(), plotOf(*scene.steps[0]));
    if (found->second.dots != nullptr) scene.dots = found->second.dots(scene.view);
    if (found->second.mesh == nullptr) return scene;
    scene.steps.emplace_back();
    scene.meshes.resize(scene.view.layers.size());
    scene.meshes.back() = meshOf(found->second.mesh, 0, 0);
    return scene;
}

}  // namespace mote::test
