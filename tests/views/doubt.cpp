// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/doubt.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "server/render/layers/hybrid/lower_hybrid.h"
#include "tests/reference/reference_renderer.h"
#include "tests/reference/scene_styles.h"

namespace mote::test {
namespace {

constexpr double pixelShift = 1e-3;     // pixels
constexpr double depthShift = 0x1p-23;  // of the depths that are drawn
constexpr double knotShift = 0x1p-16;   // of the range of values
constexpr double cutShift = 0x1p-20;    // of the volume
constexpr double fewestSamples = 24.0, mostSamples = 192.0, closeSamples = 768.0;
constexpr double enoughPixels = 384.0;  // for which the fewest samples do
constexpr double enoughCertain = 0.03;  // share in doubt with which no more samples are tried

/// The box of a layer in layer space; of dots, where they are made.
Bounds boundsOf(const render::Scene& scene, std::size_t layer) {
    const auto& data = scene.layers[layer];
    if (data.mesh) return data.mesh->bounds();
    return data.hybrid ? data.hybrid->bounds() : plotBounds;
}

/// How deep all is that a camera may see.
double depthRange(const render::Scene& scene) {
    double nearest = std::numeric_limits<double>::infinity(), farthest = -nearest;
    const Camera& camera = scene.view.camera;
    for (std::size_t i = 0; i < scene.view.layers.size(); ++i) {
        const auto box = boundsOf(scene, i).transformed(camera.worldToEye() * scene.view.layers[i].transform);
        nearest = std::min(nearest, -box.max.z);
        farthest = std::max(farthest, -box.min.z);
    }
    if (camera.perspective()) nearest = std::max(nearest, 0.0);
    return std::max(farthest - nearest, 0.0);
}

/// Eye space moved by a share of a pixel, and in depth.
glm::dmat4 shift(const View& view, double pixels, double depth) {
    const double pixel = 2.0 * view.camera.halfHeight() / view.height;
    glm::dmat4 result(1.0);
    // Of a perspective picture a pixel is as wide as it is deep.
    auto& column = result[view.camera.perspective() ? 2 : 3];
    const double along = view.camera.perspective() ? -1.0 : 1.0;
    column.x += along * pixels * pixel;
    column.y += along * 0.7 * pixels * pixel;
    result[3].z += depth;
    return result;
}

/// Of knots that move beyond the greatest place only the first is met, as if the others lay behind it.
Curve movedCurve(const Curve& curve, double offset, double least, double greatest) {
    std::vector<Curve::Knot> knots;
    for (const auto& knot : curve.knots()) {
        const bool beyond = knot.x + offset > greatest;
        knots.push_back({std::clamp(knot.x + offset, least, greatest), knot.y});
        if (beyond) break;
    }
    return Curve::create(std::move(knots), least, greatest).value();
}

/// `box`: null where there is none.
void moveClips(ClipPlanes& planes, proto::ClipBox* box, double shift) {
    for (auto& plane : planes) plane.set_distance(plane.distance() + shift);
    if (box == nullptr) return;
    for (auto* const corner : {box->mutable_min(), box->mutable_max()})
        for (double& place : *corner) place += shift;
}

void moveStyle(proto::HybridStyle& style, const render::GridField& step, double way) {
    const double range = step.range.high - step.range.low;
    constexpr double widest = std::numeric_limits<double>::max();
    const auto said = hybridStyleOf(style).opacity;
    const auto moved =
        movedCurve(said ? *said : render::defaultOpacity(step), way * knotShift * range, -widest, widest);
    for (int i = 0; const auto& knot : moved.knots()) {
        auto& written = i < style.curve_size() ? *style.mutable_curve(i) : *style.add_curve();
        written.set_value(knot.x);
        written.set_opacity(knot.y);
        ++i;
    }
    if (style.has_isovalue()) style.set_isovalue(style.isovalue() + way * knotShift * range);
    const double shift = way * cutShift * glm::length(step.bounds().size());
    moveClips(*style.mutable_clip_planes(), style.has_clip_box() ? style.mutable_clip_box() : nullptr, shift);
}

void moveLayer(render::Scene& scene, std::size_t i, double way, double range) {
    Layer& layer = scene.view.layers[i];
    const glm::dmat4 worldToEye = scene.view.camera.worldToEye();
    const double depth = way * static_cast<double>(i + 1) * depthShift * range;
    const glm::dmat4 shifted = shift(scene.view, way * pixelShift, depth) * worldToEye * layer.transform;
    layer.transform = glm::inverse(worldToEye) * shifted;
    if (layer.particles() != nullptr) {
        auto& style = particlesIn(scene, i);
        style.volumeOpacity = movedCurve(style.volumeOpacity, way * knotShift, 0.0, 1.0);
    }
    if (auto* const style = std::get_if<proto::HybridStyle>(&layer.style))
        moveStyle(*style, *scene.layers[i].hybrid, way);
    if (!layer.clip) return;
    const double extent = glm::length(boundsOf(scene, i).size());
    moveClips(*layer.clip->mutable_planes(), layer.clip->has_box() ? layer.clip->mutable_box() : nullptr,
              way * cutShift * extent);
}

bool differ(const Image& one, const Image& other, std::size_t pixel) {
    for (std::size_t c = 0; c < 3; ++c)
        if (std::abs(one.pixels[4 * pixel + c] - other.pixels[4 * pixel + c]) > 1) return true;
    return false;
}

/// In a picture of few pixels one weighs much that all samples mistake alike, at a step of a curve between
/// two of them: it gets more, which cost as much as in others.
double firstSamples(const View& view) {
    const double pixels = static_cast<double>(view.width) * view.height;
    double samples = fewestSamples;
    while (samples < mostSamples && samples * pixels < fewestSamples * enoughPixels) samples *= 2.0;
    return samples;
}

Judgement judgeWith(const render::Scene& scene, double samples) {
    const auto picture = reference::render(scene, {samples});
    Judgement judgement{reference::encode(picture), picture.ambiguous, samples};
    for (const double way : {1.0, -1.0}) {
        const auto other = reference::encode(reference::render(moved(scene, way), {0.5 * samples}));
        for (std::size_t i = 0; i < judgement.doubtful.size(); ++i)
            if (differ(judgement.expected, other, i)) judgement.doubtful[i] = 1;
    }
    return judgement;
}

}  // namespace

double Judgement::doubtfulShare() const {
    const auto certain = std::count(doubtful.begin(), doubtful.end(), 0);
    return 1.0 - static_cast<double>(certain) / static_cast<double>(doubtful.size());
}

render::Scene moved(const render::Scene& scene, double way) {
    render::Scene result = scene;
    const double range = depthRange(scene);
    for (std::size_t i = 0; i < scene.view.layers.size(); ++i) moveLayer(result, i, way, range);
    if (scene.dots == nullptr) return result;
    auto dots = std::make_shared<render::Dots>(*scene.dots);
    const double more = static_cast<double>(scene.view.layers.size() + 1);
    for (auto& dot : *dots) {
        dot.x += static_cast<float>(way * pixelShift);
        dot.y += static_cast<float>(0.7 * way * pixelShift);
        dot.depth -= way * more * depthShift * range;
    }
    result.dots = std::move(dots);
    return result;
}

Judgement judge(const render::Scene& scene) {
    double samples = firstSamples(scene.view);
    while (true) {
        auto judgement = judgeWith(scene, samples);
        if (samples >= mostSamples || judgement.doubtfulShare() <= enoughCertain) return judgement;
        samples *= 2.0;
    }
}

Judgement judgeClosely(const render::Scene& scene) {
    return judgeWith(scene, closeSamples);
}

}  // namespace mote::test
