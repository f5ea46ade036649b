// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/golden/golden_colors.h"

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <map>

#include "storage/numbers/point_places.h"
#include "tests/golden/golden_scenes.h"
#include "tests/support/beams.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::test {
namespace {

std::shared_ptr<const MemoryStep> wideBeam() {
    BeamShape shape{.core = 60000, .halo = 20000, .filaments = 8000};
    shape.coreSigma = 0.12;
    shape.seed = 12;
    return MemoryStep::make(beam(shape), {.leafCapacity = 64, .maxLevel = 8, .volumeLevel = 5});
}

/// A ball without volume, most of which lies before the middle of the box.
std::shared_ptr<const MemoryStep> ball() {
    BeamShape shape{.core = 20000, .halo = 0, .filaments = 0};
    shape.coreSigma = 0.08;
    shape.seed = 13;
    return MemoryStep::make(beam(shape), {.leafCapacity = 64, .maxLevel = 8, .volumeLevel = 5});
}

/// By value of a place in layer space; NaN: none.
using ValueAt = std::function<double(const glm::dvec3&)>;

std::shared_ptr<const render::PointValues> valuesOf(const MemoryStep& step, const ValueAt& at) {
    const storage::LeafWalk walk(step);
    auto values = std::make_shared<render::PointValues>();
    for (std::uint64_t point = 0; point < step.pointCount(); ++point) {
        const auto place = walk.cell(walk.leafOf(point)).at(step.positions(point, 1).front());
        values->codes.push_back(render::codeOf(at(place), {0.0, 1.0}));
        values->complete = values->complete && values->codes.back() != render::noValue;
    }
    return values;
}

double waves(const glm::dvec3& at) {
    return 0.5 + 0.5 * std::sin(9.0 * at.x + 4.0 * at.y);
}

/// In a part of the core whole leaves have no value, and elsewhere some points of a leaf.
double wavesWithHoles(const glm::dvec3& at) {
    if (glm::length(at - glm::dvec3(0.25, 0.2, 0.4)) < 0.3) return std::nan("");
    if (at.z < 0.0 && std::fmod(std::abs(at.x) * 1e4, 1.0) < 0.3) return std::nan("");
    return waves(at);
}

/// Turns that come nearer and cross each other.
std::shared_ptr<const render::PointPaths> spirals() {
    auto paths = std::make_shared<render::PointPaths>();
    for (const double phase : {0.0, 1.5, 3.0}) {
        paths->begin.push_back(static_cast<std::uint32_t>(paths->places.size()));
        for (int i = 0; i <= 60; ++i) {
            const double turn = phase + 0.2 * i;
            paths->places.emplace_back(0.4 * std::cos(turn), 0.5 * std::sin(1.3 * turn), 0.8 - 0.025 * i);
        }
    }
    paths->begin.push_back(static_cast<std::uint32_t>(paths->places.size()));
    return paths;
}

const char* const mean = R"({
  'width': 320, 'height': 180,
  'camera': {'eye': [1.2, 0.8, 2], 'target': [0, 0, 0]},
  'layers': [{'colorBy': {'column': 'value'}, 'particles': {
    'volume': {'curve': [{'density': 0.2, 'opacity': 0}, {'density': 0.8, 'opacity': 0.25}]},
    'points': {'opacity': 0.3}}}]})";

const char* const opaque = R"({
  'width': 320, 'height': 180, 'background': [1, 1, 1],
  'camera': {'eye': [-1.1, 0.9, 1.8], 'target': [0, 0, 0]},
  'layers': [{'colorBy': {'column': 'value', 'colorMap': 'turbo'}, 'particles': {
    'volume': {'curve': [{'density': 0.3, 'opacity': 0}, {'density': 1, 'opacity': 0.3}]},
    'points': {'opacity': 1, 'sizePixels': 2.5}}}]})";

const char* const marks = R"({
  'width': 320, 'height': 180, 'background': [0.1, 0.1, 0.3],
  'camera': {'eye': [1.2, 0.8, 2], 'target': [0, 0, 0]},
  'layers': [{'highlight': {'selection': {}, 'sizePixels': 2, 'opacity': 0.8},
    'paths': {'ids': [1], 'width': 2.5, 'color': [1, 0.9, 0.2]},
    'particles': {'volume': {'curve': [{'density': 0, 'opacity': 0}]}, 'points': {'opacity': 0.5}}}]})";

}  // namespace

const std::vector<GoldenScene>& goldenColors() {
    static const std::vector<GoldenScene> all{
        {"coloredMean", 0.2, 0.1, 0.03},
        {"coloredWithHoles", 0.2, 0.1, 0.03},
        // Which of two points of nearly one depth is the nearest hangs on rounding.
        {"coloredOpaque", 0.2, 0.05, 0.05, {50.0, 0.999, 32}},
        {"marks", 0.15, 0.0, 0.0},
    };
    return all;
}

std::optional<render::Scene> makeColoredScene(const std::string& name) {
    struct Recipe {
        const char* view;
        ValueAt values;
    };
    static const std::map<std::string, Recipe> all{{"coloredMean", {mean, waves}},
                                                   {"coloredWithHoles", {mean, wavesWithHoles}},
                                                   {"coloredOpaque", {opaque, waves}},
                                                   {"marks", {marks, {}}}};
    const auto found = all.find(name);
    if (found == all.end()) return std::nullopt;
    render::Scene scene{viewOf(found->second.view), {}};
    const auto step = found->second.values ? wideBeam() : ball();
    scene.steps.push_back(step);
    if (found->second.values) {
        scene.values.push_back(valuesOf(*step, found->second.values));
        return scene;
    }
    scene.highlights.push_back(step);
    scene.paths.push_back(spirals());
    return scene;
}

}  // namespace mote::test
