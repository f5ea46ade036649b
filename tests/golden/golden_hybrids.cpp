// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/golden/golden_hybrids.h"

#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <stdexcept>

#include "tests/golden/golden_scenes.h"
#include "tests/support/beams.h"
#include "tests/support/hybrid_scene.h"
#include "tests/support/memory_step.h"
#include "tests/support/view_text.h"

namespace mote::test {
namespace {

/// Uneven voxels, a box that is turned and not at the origin: about 60 x 50 x 56 units.
glm::dmat4 turnedBox() {
    const glm::dmat4 place = glm::translate(glm::dmat4(1.0), glm::dvec3(10.0, -5.0, 20.0));
    const glm::dmat4 turned = glm::rotate(place, 0.4, glm::normalize(glm::dvec3(0.2, 1.0, 0.1)));
    return glm::translate(glm::scale(turned, glm::dvec3(60.0, 50.0, 56.0)), glm::dvec3(-0.5));
}

/// Parts that the coarse grid of 12^3 blurs; 2 to 202 in the source's unit.
std::shared_ptr<const render::GridField> machine(HybridRepresentation parts) {
    const HybridShape shape{.source = {48, 40, 28},
                            .low = {12, 10, 7},
                            .boxToLayer = turnedBox(),
                            .range = {2.0, 202.0},
                            .threshold = 12.0,
                            .parts = parts};
    return hybridOf(shape, [](const glm::dvec3& at) { return 2.0 + 200.0 * machineParts(at); });
}

// Glass around metal.
const std::string curve = R"('curve': [{'value': 45, 'opacity': 0}, {'value': 60, 'opacity': 0.02},
    {'value': 100, 'opacity': 0.02}, {'value': 130, 'opacity': 0.25}, {'value': 202, 'opacity': 0.6}])";
const std::string camera = "'camera': {'eye': [60, 40, 120], 'target': [10, -5, 20], 'fovYDegrees': 32}";

std::string hybridView(const std::string& style, const std::string& size = "'width': 240, 'height': 180") {
    return "{" + size + ", " + camera + ", 'layers': [{'hybrid': {" + style + ", " + curve + "}}]}";
}

const std::string cuts = R"('representation': 'residual', 'colorMap': 'viridis',
    'clipPlanes': [{'normal': [-1, 0.2, -0.5], 'distance': -19}], 'clipBox': {'min': [-20, -28, -9], 'max': [33, 14, 60]})";

// The beam passes through the machine; its points and volume lie within the hybrid one.
const std::string withBeam = R"({'width': 240, 'height': 180, )" + camera + R"(, 'layers': [
    {'hybrid': {'representation': 'points', 'pointShape': 'disc', )" +
                             curve + R"(}},
    {'transform': [25, 0, 0, 10,  0, 25, 5, -5,  0, 0, 30, 20,  0, 0, 0, 1], 'particles': {
      'volume': {'colorMap': 'viridis', 'curve': [{'density': 0.2, 'opacity': 0}, {'density': 1, 'opacity': 0.3}]},
      'points': {'opacity': 0.8}}}]})";

const std::map<std::string, std::string>& views() {
    static const std::map<std::string, std::string> all{
        {"hybridVolume", hybridView("'representation': 'volume'")},
        {"hybridResidual", hybridView("'representation': 'residual'")},
        {"hybridSquares", hybridView("'representation': 'points', 'pointShape': 'square'")},
        {"hybridDiscs", hybridView("'representation': 'points', 'pointShape': 'disc'")},
        {"hybridGaussians", hybridView("'representation': 'points', 'pointShape': 'gaussian'")},
        {"hybridSmall",
         hybridView("'representation': 'points', 'pointOpacity': 0.7", "'width': 56, 'height': 42")},
        {"hybridCut", hybridView(cuts)},
        {"hybridUnlit", hybridView("'representation': 'residual', 'light': {'ambient': 1, 'diffuse': 0, "
                                   "'specular': 0}")},
        {"hybridWithBeam", withBeam},
    };
    return all;
}

std::shared_ptr<const MemoryStep> beamInside() {
    const BeamShape shape{.core = 20000, .halo = 4000, .filaments = 2000};
    return MemoryStep::make(beam(shape), {.leafCapacity = 64, .maxLevel = 8, .volumeLevel = 5});
}

}  // namespace

const std::vector<GoldenScene>& goldenHybrids() {
    // The shares are about two thirds of what the scenes show.
    static const std::vector<GoldenScene> all{
        // Light bends within the cells of the coarse grid, which are a dozen pixels large here.
        {"hybridVolume", 0.1, 0.0, 0.0, {50.0, 0.995, 12}},
        {"hybridResidual", 0.2, 0.0, 0.1},
        // A face an eighth of a cell thick is found to within the shortest segment, a tenth of a cell.
        {"hybridSquares", 0.2, 0.0, 0.05, {50.0, 0.99, 32}},
        {"hybridDiscs", 0.2, 0.0, 0.05, {50.0, 0.997, 26}},
        {"hybridGaussians", 0.2, 0.0, 0.05},
        {"hybridSmall", 0.2, 0.0, 0.05},
        {"hybridCut", 0.1, 0.0, 0.05},
        {"hybridUnlit", 0.2, 0.0, 0.1},
        // On egl, points of the beam that share a pixel and a slab are mixed with the volume there.
        {"hybridWithBeam", 0.2, 0.0, 0.03, {45.0, 0.998, 12}},
    };
    return all;
}

render::Scene makeHybridScene(const std::string& name) {
    const auto found = views().find(name);
    if (found == views().end()) throw std::invalid_argument("no golden scene is called " + name);
    render::Scene scene{viewOf(found->second), {}};
    for (const auto& layer : scene.view.layers) {
        const bool hybrid = layer.hybrid() != nullptr;
        scene.hybrids.push_back(hybrid ? machine(hybridStyleOf(*layer.hybrid()).representation) : nullptr);
        scene.steps.push_back(hybrid ? nullptr : beamInside());
    }
    return scene;
}

}  // namespace mote::test
