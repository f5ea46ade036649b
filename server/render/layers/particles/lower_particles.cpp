// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/particles/lower_particles.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "server/render/layers/particles/lower_highlight.h"
#include "server/render/layers/particles/lower_paths.h"

namespace mote::render {
namespace {

/// How far a point's footprint reaches from its centre (docs/PICTURE.md, "Points").
double footprintReach(double pointSize) {
    return pointSize > 1.0 ? 0.5 * pointSize + 0.5 : 0.0;
}

PointLook lookOf(const Layer& layer, const ParticlesStyle& style, double pixels, double share) {
    return {.size = style.pointSize * pixels,
            .opacity = std::min(-std::expm1(std::log1p(-style.pointOpacity) / share),
                                TransferFunction::opacityLimit),
            .color = style.pointColor,
            .thinned = layer.opacity};
}

std::uint64_t pointsInView(const PointsPlan& points) {
    if (points.leavesInView.empty()) return points.selection->points;
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < points.selection->drawn.size(); ++i) sum += points.drawn(i);
    return sum;
}

/// What the points and the volume of a layer need in memory; of the points of an octree that is not there
/// yet, none.
storage::StepNeed needOf(const storage::ParticleStep& step, const Curve& fraction) {
    if (zeroFrom(fraction) <= 0.0) return {.volume = true};
    storage::StepNeed need{.preview = storage::Preview::mostPoints, .volume = true, .octree = true};
    if (step.octreeReady()) need.points = {{0, pointsUpTo(step, fraction)}};
    return need;
}

bool ready(const storage::ParticleStep& step, const storage::StepNeed& need) {
    return step.octreeReady() && std::all_of(need.points.begin(), need.points.end(), [&](const auto& range) {
               return step.positionsReady(range.begin, range.count) == range.count;
           });
}

/// Takes the points from the preview. False where it does not reach so far.
bool takePreview(PointsPlan& points, double share) {
    const auto preview = selectPreview(*points.step, points.fraction, share);
    if (!preview) return false;
    points.preview = std::make_shared<const PreviewSelection>(*preview);
    points.selection = std::make_shared<const PointSelection>();
    points.pointsDrawn = preview->points;
    points.share = share;
    return true;
}

/// A step of no more is read on the spot, and so is half as much of a preview: in a moment.
constexpr std::uint64_t fewPoints = std::uint64_t{1} << 21;

/// As takePreview, of no more of the preview than is in memory, or than is read in a moment.
bool takeWhatIsReady(PointsPlan& points, double share) {
    constexpr std::uint64_t read = fewPoints / 2;
    if (points.step->pointCount() <= fewPoints) return false;
    const auto offered = std::max(read, points.step->previewReady(storage::Preview::mostPoints));
    const double shown = previewShare(*points.step, points.fraction, share, offered);
    if (!(shown > 0.0) || !takePreview(points, shown)) return false;
    points.waits = shown < share;
    points.colors.reset();
    return true;
}

/// A small share of a plot that lies mostly in view comes from the preview.
void select(PointsPlan& points, const Frustum& frustum, const Lowering& out) {
    const double share = points.share = out.quality.pointFraction;
    points.need = needOf(*points.step, points.fraction);
    if (!out.device.allPoints) points.need.points.clear();
    if (!points.need.octree) {
        points.selection = std::make_shared<const PointSelection>();
        return;
    }
    if (out.device.preview && out.reading == Reading::notForPoints && !ready(*points.step, points.need) &&
        takeWhatIsReady(points, share)) {
        return;
    }
    points.leavesInView = leavesInView(*points.step, frustum, points.fraction);
    // The preview does not tell which points of the step its own are.
    const bool preview = out.device.preview && !points.colors;
    if (preview && share < 1.0 && points.leavesInView.empty() && takePreview(points, share)) {
        return;
    }
    points.selection = out.selections.of(points.step, points.fraction, share);
    points.pointsDrawn = pointsInView(points);
}

/// What of a layer of particles a scene has, where it has any.
template <class T>
std::shared_ptr<const T> partOf(const std::vector<std::shared_ptr<const T>>& all, std::size_t index) {
    return index < all.size() ? all[index] : nullptr;
}

/// Without values, points have the colour of their look. The preview knows no values.
std::optional<PointColors> colorsOf(const Layer& layer, std::shared_ptr<const PointValues> values) {
    if (!layer.colorBy || values == nullptr) return std::nullopt;
    return PointColors{std::move(values), layer.colorBy->colorMap,
                       layer.colorBy->ofPixel == ColorBy::OfPixel::nearest};
}

/// What lies over a layer's points.
void lowerMarks(const Scene& scene, std::size_t index, const ParticlesStyle& style, const Bounds& inEye,
                Lowering& out) {
    const Layer& layer = scene.view.layers[index];
    if (auto chosen = partOf(scene.highlights, index); layer.highlight && chosen) {
        out.highlights.emplace_back([&layer, &style, chosen = std::move(chosen), inEye, &out] {
            lowerHighlight(layer, *layer.highlight, style, *chosen, inEye, out);
        });
    }
    if (const auto paths = partOf(scene.paths, index); layer.paths && paths)
        lowerPaths(layer, *layer.paths, style.pointColor, *paths, out);
}

}  // namespace

void lowerParticles(const Scene& scene, std::size_t index, const ParticlesStyle& style, Lowering& out) {
    const FramePlan& plan = out.plan;
    const Layer& layer = scene.view.layers[index];
    const auto& step = scene.steps[index];
    const glm::dmat4 layerToEye = plan.camera.worldToEye() * layer.transform;
    const glm::dmat4 boxToEye = layerToEye * plotToLayer();
    const Bounds inEye = plotBounds.transformed(layerToEye);
    out.addBox(inEye);
    PointsPlan points{.layer = index,
                      .step = step,
                      .boxToEye = boxToEye,
                      .fraction = style.pointFraction,
                      .colors = colorsOf(layer, partOf(scene.values, index))};
    const Frustum frustum(plan.camera, plan.width, plan.height, footprintReach(style.pointSize * out.pixels),
                          nearLimit(plan.camera), layerToEye);
    select(points, frustum, out);
    points.look = lookOf(layer, style, out.pixels, points.share);
    out.plan.points.push_back(std::move(points));
    lowerMarks(scene, index, style, inEye, out);
    auto transfer = thinned(style.transfer(), layer.opacity);
    if (!transfer.visible()) return;
    out.plan.fields.push_back({.layer = index,
                               .boxToEye = boxToEye,
                               .transfer = std::move(transfer),
                               .samples = DensityField{step}});
}

}  // namespace mote::render
