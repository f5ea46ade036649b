// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/particles/lower_particles.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "protocol/scene/srgb.h"
#include "server/render/layers/particles/moving_look.h"
#include "server/render/plan/hidden_area.h"

namespace mote::render {
namespace {

/// How far a point's footprint reaches from its centre (docs/PICTURE.md, "Points").
double footprintReach(double pointSize) {
    return pointSize > 1.0 ? 0.5 * pointSize + 0.5 : 0.0;
}

/// The diameter at which a point of so much light, in square pixels, hides half of what lies behind it, or
/// nearly all where that is light; one pixel where it hides less.
double sizeOfLight(double light, bool onLight) {
    const double fullest = onLight ? 2.0 : 0.7;  // optical depth
    constexpr double largest = 64.0;             // pixels
    const double area = light / fullest;
    if (area <= discArea(1.0 + 1e-9)) return 1.0;
    return std::min(2.0 * std::sqrt(area / std::numbers::pi - 1.0 / 12.0), largest);
}

/// Of an optical depth at depth 1, that where the camera looks.
double toTarget(const Camera& camera) {
    if (!camera.perspective()) return 1.0;
    const double away = glm::length(camera.target - camera.eye);
    return 1.0 / (away * away);
}

/// If the opacity is the plot's, the light of a point is that of a particle in the world. `height`: of the
/// picture, pixels.
void lightUp(const Layer& layer, const ParticlesStyle& style, const FramePlan& plan, double height,
             PointLook& look) {
    const Camera& camera = plan.camera;
    const double unit = std::cbrt(std::abs(glm::determinant(glm::dmat3(layer.transform))));
    const double pixels = unit * height / (2.0 * camera.halfHeight());  // of a unit of the layer at depth 1
    const double light = style.pointArea * pixels * pixels;
    look.size = style.sizeByPlot ? sizeOfLight(light * toTarget(camera), isLight(plan.background))
                                 : std::max(look.size, 1.0);
    look.light = std::max(light / discArea(look.size), std::numeric_limits<double>::min());
}

/// Of points of the mean weight in the exact picture, of so many lines.
PointLook restingLook(const Layer& layer, const ParticlesStyle& style, const FramePlan& plan, double height) {
    PointLook look{.size = style.pointSize,
                   .opacity = std::min(style.pointOpacity, TransferFunction::opacityLimit),
                   .color = style.pointColor,
                   .thinned = layer.opacity};
    if (style.opacityByPlot && style.pointArea > 0.0) lightUp(layer, style, plan, height, look);
    return look;
}

/// The look of a layer's points, as there are more or fewer of them.
class PointLooks {
  public:
    /// `weight`: of the step's points, of which there are so many.
    PointLooks(const Layer& layer, const ParticlesStyle& style, const Scene& scene, const StepWeight& weight,
               std::uint64_t points, const Lowering& out)
        : rest_(restingLook(layer, style, out.plan, scene.view.height)),
          weight_(weight),
          points_(points),
          toTau_(toTarget(out.plan.camera)),
          pixels_(out.pixels) {}

    /// Of a share of the points; of the step's mean weight, or of that of the plot.
    PointLook of(double share, bool ofStep) const {
        PointLook rest = rest_;
        if (ofStep) rest.light *= weight_.mean;
        return movingLook(rest, toTau_, less(share));
    }

    Thinning thinning(double share) const {
        const LessDrawn drawn = less(share);
        if (weight_.even || !(rest_.light > 0.0) || drawn.nothing()) return {};
        const double most = drawn.grows ? mostTau : mostTauUngrown;
        return Thinning::roughly({rest_.light * toTau_, rest_.size, of(share, false).size, pixels_, most});
    }

    const StepWeight& weight() const { return weight_; }

  private:
    LessDrawn less(double share) const { return LessDrawn::of(pixels_, share, rest_.size, points_); }

    PointLook rest_;
    StepWeight weight_;
    std::uint64_t points_;
    double toTau_, pixels_;
};

std::uint64_t pointsInView(const PointsPlan& points) {
    if (points.leavesInView.empty()) return points.selection->points;
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < points.selection->drawn.size(); ++i) sum += points.drawn(i);
    return sum;
}

/// What the points and the volume of a layer need in memory; of the points of an octree that is not there
/// yet, none.
storage::StepNeed needOf(const PointsPlan& points, SelectionCache& selections) {
    const bool none = zeroFrom(points.fraction) <= 0.0 && !points.choice().thin();
    storage::StepNeed need{
        .preview = none ? 0 : storage::Preview::mostPoints, .volume = true, .octree = true};
    if (!none && points.step->octreeReady()) need.points = selections.needed(points.step, points.choice());
    return need;
}

bool byColumn(const PointsPlan& points) {
    return points.colors && points.colors->values != nullptr;
}

bool ready(const storage::ParticleStep& step, const storage::StepNeed& need) {
    return step.octreeReady() && std::all_of(need.points.begin(), need.points.end(), [&](const auto& range) {
               return step.positionsReady(range.begin, range.count) == range.count;
           });
}

/// Takes the points from the preview. False if it does not reach so far.
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
    if (byColumn(points)) points.colors.reset();
    return true;
}

/// A small share of a plot that lies mostly in view comes from the preview. `alike`: all points weigh the
/// same, and it is not worth its time that they move. `cut`: some are cut away; the preview does not tell
/// which.
void select(PointsPlan& points, const Frustum& frustum, bool alike, bool cut, const Lowering& out) {
    const double share = points.share = out.quality.pointFraction;
    points.need = needOf(points, out.selections);
    const bool none = points.need.preview == 0;
    if (!out.device.allPoints) points.need.points.clear();
    if (none) {
        points.selection = std::make_shared<const PointSelection>();
        return;
    }
    const bool waits =
        out.device.preview && out.reading == Reading::notForPoints && !ready(*points.step, points.need);
    if (waits && cut && points.step->pointCount() > fewPoints) {
        points.selection = std::make_shared<const PointSelection>();
        points.waits = true;
        return;
    }
    if (waits && takeWhatIsReady(points, share)) return;
    points.leavesInView = leavesInView(*points.step, frustum, points.choice());
    // The preview does not tell which points of the step its own are, nor their weights, nor which leaves are
    // thin.
    const bool preview = out.device.preview && alike && !cut && !byColumn(points) && !points.choice().thin();
    if (preview && share < 1.0 && points.leavesInView.empty() && takePreview(points, share)) {
        return;
    }
    points.selection = out.selections.of(points.step, points.choice());
    points.pointsDrawn = pointsInView(points);
}

/// Where a layer's points go that are on their way to another step; null: nowhere. Other processes have their
/// points from the step's file.
std::shared_ptr<const PointWays> waysOf(const Scene& scene, std::size_t index, const Lowering& out) {
    if (!out.device.allPoints || !scene.view.layers[index].towards) return nullptr;
    return scene.layers[index].ways;
}

/// Points of leaves go on their way.
void move(PointsPlan& points, const std::shared_ptr<const PointWays>& ways, double share,
          const Lowering& out) {
    if (ways == nullptr || points.preview != nullptr || points.selection->points == 0) return;
    auto moved = out.selections.moved(points.step, points.selection, ways, share,
                                      points.colors ? points.colors->values : nullptr);
    points.source = std::exchange(points.step, std::move(moved.step));
    points.selection = std::move(moved.selection);
    points.leavesInView.clear();
    points.pointsDrawn = points.selection->points;
    if (points.colors) points.colors->values = std::move(moved.values);
}

/// What clips leave of points that are drawn from leaves.
void cut(PointsPlan& points, const HalfSpaces& clips, const Lowering& out) {
    if (clips.empty() || points.selection->points == 0) return;
    points.clips = clips;
    auto left = out.selections.cut(points.step, points.selection, clips,
                                   points.colors ? points.colors->values : nullptr);
    auto whole = std::exchange(points.step, std::move(left.step));
    if (points.source == nullptr) points.source = std::move(whole);
    points.selection = std::move(left.selection);
    points.leavesInView.clear();
    points.pointsDrawn = points.selection->points;
    if (points.colors) points.colors->values = std::move(left.values);
}

/// Without values, points have the colour of their look. The preview knows no values but densities.
std::optional<PointColors> colorsOf(const Layer& layer, const ParticlesStyle& style,
                                    std::shared_ptr<const PointValues> values) {
    if (!layer.colorBy && style.pointShade)
        return PointColors{.values = nullptr, .map = style.colorMap, .shade = style.pointShade};
    if (!layer.colorBy || values == nullptr) return std::nullopt;
    return PointColors{std::move(values), colorMapOf(*layer.colorBy), colorsOfNearest(*layer.colorBy, style)};
}

/// Whether a picture goes without the octree, since that is large and on its way.
bool treeWaits(const storage::ParticleStep& step, const Lowering& out) {
    return out.reading == Reading::notForPoints && step.pointCount() > fewPoints && !step.octreeReady();
}

/// What a layer shows as a volume; null: nothing. A view in motion does not wait for a large octree, without
/// which nobody knows whose values are where.
std::shared_ptr<const StepVolume> volumeOf(const std::shared_ptr<const storage::ParticleStep>& step,
                                           const ParticlesStyle& style,
                                           const std::shared_ptr<const PointValues>& means,
                                           const Lowering& out) {
    const auto transfer = style.transfer();
    if (!transfer.visible()) return nullptr;
    return out.selections.volume(step, transfer, style.pointFraction, treeWaits(*step, out), means);
}

/// By what a layer's volume is coloured in place of its density; null: nothing.
std::shared_ptr<const PointValues> meansOf(const std::shared_ptr<const storage::ParticleStep>& step,
                                           const ParticlesStyle& style,
                                           const std::optional<PointColors>& colors, const Lowering& out) {
    if (!colors || colors->values == nullptr || !style.transfer().visible() || treeWaits(*step, out))
        return nullptr;
    return out.selections.leafMeans(step, colors->values);
}

/// Of the field that a layer's volume is; `byValues`: it is coloured by values.
TransferFunction transferOf(const Layer& layer, const ParticlesStyle& style, bool byValues) {
    auto transfer = style.transfer();
    if (!byValues) return transfer;
    transfer.colorMap = colorMapOf(*layer.colorBy);
    transfer.colorRange = {0.0, 1.0};
    return transfer;
}

/// What lies over a layer's points.
void lowerMarks(const Scene& scene, std::size_t index, const ParticlesStyle& style, const Bounds& inEye,
                Lowering& out) {
    const Layer& layer = scene.view.layers[index];
    const LayerData& data = scene.layers[index];
    if (layer.highlight && data.highlight) {
        out.highlights.emplace_back(
            [&layer, style, chosen = data.highlight, ways = waysOf(scene, index, out), inEye, &out] {
                auto step = ways == nullptr
                                ? chosen
                                : movePoints(*chosen, nullptr, *ways, layer.towards->share, nullptr).step;
                const auto clips = layer.clips();
                if (!clips.empty()) step = cutPoints(*step, nullptr, clips, nullptr).step;
                lowerHighlight(layer, *layer.highlight, style, *step, inEye, out);
            });
    }
    if (layer.paths && data.paths) lowerPaths(layer, *layer.paths, style.pointColor, *data.paths, out);
}

}  // namespace

ParticlesStyle particlesStyleOf(const Scene& scene, std::size_t index) {
    if (scene.layers[index].particles) return *scene.layers[index].particles;
    return mote::particlesStyleOf(*scene.view.layers[index].particles());
}

void lowerParticles(const Scene& scene, std::size_t index, Lowering& out) {
    const ParticlesStyle style = particlesStyleOf(scene, index);
    const FramePlan& plan = out.plan;
    const Layer& layer = scene.view.layers[index];
    const auto& step = scene.layers[index].step;
    const glm::dmat4 layerToEye = plan.camera.worldToEye() * layer.transform;
    const glm::dmat4 boxToEye = layerToEye * plotToLayer();
    const Bounds inEye = plotBounds.transformed(layerToEye);
    out.addBox(inEye);
    auto colors = colorsOf(layer, style, scene.layers[index].values);
    const auto means = meansOf(step, style, colors, out);
    PointsPlan points{.layer = index,
                      .step = step,
                      .boxToEye = boxToEye,
                      .fraction = style.pointFraction,
                      .volume = volumeOf(step, style, means, out),
                      .meanWeight = style.opacityByPlot ? style.meanWeight : 0.0,
                      .colors = std::move(colors)};
    const double share = out.quality.pointFraction;
    const PointLooks looks(layer, style, scene,
                           out.selections.weight(step, points.meanWeight, treeWaits(*step, out)),
                           step->pointCount(), out);
    points.thinning = looks.thinning(share);
    const Frustum frustum(plan.camera, plan.width, plan.height,
                          footprintReach(looks.of(share, looks.weight().even).size), nearLimit(plan.camera),
                          layerToEye);
    const auto ways = waysOf(scene, index, out);
    const bool still = ways == nullptr || step->pointCount() > fewPoints;
    const auto clips = layer.clips();
    select(points, frustum, looks.weight().even && still, !clips.empty(), out);
    if (ways != nullptr) move(points, ways, layer.towards->share, out);
    cut(points, clips, out);
    points.waits = points.waits || (points.volume != nullptr && treeWaits(*step, out));
    const bool byLeaf = !points.selection->weights.empty();
    const bool ofStep = points.preview != nullptr || (looks.weight().even && !byLeaf);
    points.look = looks.of(points.share, ofStep);
    if (!ofStep && !byLeaf) points.look.light *= static_cast<double>(points.selection->weight);
    const auto volume = points.volume;
    out.plan.points.push_back(std::move(points));
    lowerMarks(scene, index, style, inEye, out);
    if (volume == nullptr) return;
    const glm::dmat4 boxToLayer = plotToLayer() * volume->toPlot();
    FieldPlan field{.layer = index,
                    .boxToEye = layerToEye * boxToLayer,
                    .boxToLayer = glm::dmat3(boxToLayer),
                    .transfer = transferOf(layer, style, means != nullptr),
                    .clips = inSpace(clips, boxToLayer),
                    .samples = DensityField()};
    field.samples = DensityField{step, volume, layer.opacity, means};
    out.plan.fields.push_back(std::move(field));
}

}  // namespace mote::render
