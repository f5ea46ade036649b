// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/frame_plan.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "protocol/scene/mote_check.h"

namespace mote::render {
namespace {

std::uint32_t scaledSide(std::uint32_t pixels, double scale) {
    return std::max(1U, static_cast<std::uint32_t>(std::lround(pixels * scale)));
}

/// How far a point's footprint reaches from its centre (docs/PICTURE.md, "Points").
double footprintReach(double pointSize) {
    return pointSize > 1.0 ? 0.5 * pointSize + 0.5 : 0.0;
}

ParticlesStyle scaledStyle(const ParticlesStyle& style, double pixels, double share) {
    ParticlesStyle result = style;
    result.pointSize = style.pointSize * pixels;
    result.pointOpacity =
        std::min(-std::expm1(std::log1p(-style.pointOpacity) / share), ParticlesStyle::opacityLimit);
    return result;
}

double nearLimit(const Camera& camera) {
    return camera.perspective() ? nearShare * glm::length(camera.target - camera.eye)
                                : -std::numeric_limits<double>::infinity();
}

/// Least and greatest of the finite depths; 1 and 1 where there are none.
std::pair<double, double> finiteDepths(const Dots& dots) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const Dot& dot : dots) {
        if (!std::isfinite(dot.depth)) continue;
        low = std::min(low, dot.depth);
        high = std::max(high, dot.depth);
    }
    return low > high ? std::pair(1.0, 1.0) : std::pair(low, high);
}

/// Dots of a scene for a plan of fewer pixels, without those nearer than what is seen.
std::shared_ptr<const Dots> dotsOf(const Scene& scene, const FramePlan& plan) {
    if (scene.dots == nullptr || scene.dots->empty()) return {};
    const double least = nearLimit(plan.camera);
    const auto hidden = [least](const Dot& dot) { return std::isfinite(dot.depth) && dot.depth < least; };
    const bool scaled = plan.width != scene.view.width || plan.height != scene.view.height;
    if (!scaled && std::none_of(scene.dots->begin(), scene.dots->end(), hidden)) return scene.dots;
    auto dots = std::make_shared<Dots>(*scene.dots);
    std::erase_if(*dots, hidden);
    const float across = static_cast<float>(plan.width) / static_cast<float>(scene.view.width);
    const float down = static_cast<float>(plan.height) / static_cast<float>(scene.view.height);
    for (Dot& dot : *dots) {
        dot.x *= across;
        dot.y *= down;
        dot.radius *= down;
    }
    return dots;
}

/// Where a box lies in depth. Never of no length, which rounding may make of what is far away.
DepthRange depthsOf(const Bounds& inEye, std::uint32_t slabs) {
    const double low = -inEye.max.z, high = -inEye.min.z;
    const double margin = 1e-12 * std::max(std::abs(low), std::abs(high));
    return high - low > 2.0 * margin ? DepthRange{low, high, slabs}
                                     : DepthRange{low - margin, high + margin, slabs};
}

/// Of dots the depths that are finite. They stand where they are, whatever slab that is in. `nearest`: that
/// is seen.
DepthRange depthsOf(const Dots& dots, double nearest) {
    constexpr std::uint32_t slabs = 0;
    // A little more, so that there is a range where all dots have one depth, or none: then where it is seen.
    const auto [first, last] = finiteDepths(dots);
    const double low = std::max(first, nearest), high = std::max(last, nearest);
    return {low - 1e-6 * (1.0 + std::abs(low)), high + 1e-6 * (1.0 + std::abs(high)), slabs};
}

/// In a very wide picture the rays at its corners go through a slab slantwise, and a box may lie in one slab
/// of theirs: beyond 60 degrees slabs are cut as much finer as the way through one is longer.
std::uint32_t slabsFor(const FramePlan& plan, std::uint32_t slabs) {
    if (!plan.camera.perspective()) return slabs;
    const double up = plan.camera.halfHeight(), right = up * plan.width / plan.height;
    const double way = 0.5 * std::sqrt(1.0 + right * right + up * up);
    return std::max(slabs, static_cast<std::uint32_t>(std::min<double>(slabs * way, mostSlabs)));
}

/// Cuts all depths at which layers' boxes and dots can be seen; none where there are none. `wanted`: slabs of
/// each.
void cutDepths(FramePlan& plan, std::uint32_t wanted) {
    const std::uint32_t slabs = slabsFor(plan, wanted);
    const Bounds box{glm::dvec3(0.0), glm::dvec3(1.0)};
    std::vector<DepthRange> contents;
    for (const auto& layer : plan.layers)
        contents.push_back(depthsOf(plotBounds.transformed(layer.layerToEye), slabs));
    for (const auto& layer : plan.hybrids)
        contents.push_back(depthsOf(box.transformed(layer.boxToEye), slabs));
    if (plan.anyDots()) contents.push_back(depthsOf(*plan.dots, nearLimit(plan.camera)));
    for (auto& range : contents) range.nearDepth = std::max(range.nearDepth, nearLimit(plan.camera));
    plan.sections = depthSections(contents);
    if (plan.sections.empty()) return;
    plan.nearDepth = plan.sections.front().nearDepth;
    plan.farDepth = plan.sections.back().farDepth;
    plan.slabs = plan.sections.back().endSlab();
}

std::uint64_t pointsInView(const LayerPlan& layer) {
    if (layer.leavesInView.empty()) return layer.selection->points;
    std::uint64_t points = 0;
    for (std::size_t i = 0; i < layer.selection->drawn.size(); ++i) points += layer.drawn(i);
    return points;
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

/// Takes the points of a layer from the preview. False where it does not reach so far.
bool planPreview(LayerPlan& layer, const Curve& fraction, double share) {
    const auto preview = selectPreview(*layer.step, fraction, share);
    if (!preview) return false;
    layer.preview = std::make_shared<const PreviewSelection>(*preview);
    layer.selection = std::make_shared<const PointSelection>();
    layer.pointsDrawn = preview->points;
    layer.share = share;
    return true;
}

/// A step of no more is read on the spot, and so is half as much of a preview: in a moment.
constexpr std::uint64_t fewPoints = std::uint64_t{1} << 21;

/// As planPreview, of no more of the preview than is in memory, or than is read in a moment.
bool planWhatIsReady(LayerPlan& layer, const Curve& fraction, double share) {
    constexpr std::uint64_t read = fewPoints / 2;
    if (layer.step->pointCount() <= fewPoints) return false;
    const auto points = std::max(read, layer.step->previewReady(storage::Preview::mostPoints));
    const double shown = previewShare(*layer.step, fraction, share, points);
    if (!(shown > 0.0) || !planPreview(layer, fraction, shown)) return false;
    layer.waits = shown < share;
    return true;
}

/// The points of a layer: a small share of a plot that lies mostly in view comes from the preview.
void planPoints(LayerPlan& layer, const Curve& fraction, const Frustum& frustum, double share,
                SelectionCache& selections, DeviceAbilities device, Reading reading) {
    layer.share = share;
    layer.need = needOf(*layer.step, fraction);
    if (!device.allPoints) layer.need.points.clear();
    if (!layer.need.octree) {
        layer.selection = std::make_shared<const PointSelection>();
        return;
    }
    if (device.preview && reading == Reading::notForPoints && !ready(*layer.step, layer.need) &&
        planWhatIsReady(layer, fraction, share)) {
        return;
    }
    layer.leavesInView = leavesInView(*layer.step, frustum, fraction);
    if (device.preview && share < 1.0 && layer.leavesInView.empty() && planPreview(layer, fraction, share)) {
        return;
    }
    layer.selection = selections.of(layer.step, fraction, share);
    layer.pointsDrawn = pointsInView(layer);
}

struct Planning {
    SelectionCache& selections;
    DeviceAbilities device;
    Reading reading;
    double pixels;  ///< of the plan, a pixel of the view
};

LayerPlan planLayer(const Layer& layer, const ParticlesStyle& style,
                    std::shared_ptr<const storage::ParticleStep> step, const FramePlan& plan,
                    const Quality& quality, const Planning& planning) {
    LayerPlan result{.step = std::move(step),
                     .layerToEye = plan.camera.worldToEye() * layer.transform,
                     .style = style,
                     .selection = {},
                     .leavesInView = {},
                     .preview = {}};
    const Frustum frustum(plan.camera, plan.width, plan.height,
                          footprintReach(style.pointSize * planning.pixels), nearLimit(plan.camera),
                          result.layerToEye);
    planPoints(result, style.pointFraction, frustum, quality.pointFraction, planning.selections,
               planning.device, planning.reading);
    result.style = scaledStyle(style, planning.pixels, result.share);
    return result;
}

}  // namespace

bool FramePlan::waits() const {
    return std::any_of(layers.begin(), layers.end(), [](const LayerPlan& layer) { return layer.waits; });
}

FramePlan makeFramePlan(const Scene& scene, const Quality& quality) {
    SelectionCache selections;
    return makeFramePlan(scene, quality, selections, {});
}

FramePlan makeFramePlan(const Scene& scene, const Quality& quality, SelectionCache& selections,
                        DeviceAbilities device, Reading reading) {
    MOTE_CHECK(scene.steps.size() == scene.view.layers.size());
    MOTE_CHECK(quality.resolutionScale > 0.0 && quality.resolutionScale <= 1.0);
    MOTE_CHECK(quality.pointFraction > 0.0 && quality.pointFraction <= 1.0);
    const View& view = scene.view;
    FramePlan plan{.width = scaledSide(view.width, quality.resolutionScale),
                   .height = scaledSide(view.height, quality.resolutionScale),
                   .camera = view.camera,
                   .background = view.background,
                   .samplesPerCell = quality.samplesPerCell,
                   .exact = quality == Quality::exact(),
                   .layers = {}};
    const Planning planning{selections, device, reading, static_cast<double>(plan.height) / view.height};
    for (std::size_t i = 0; i < view.layers.size(); ++i) {
        if (view.layers[i].hybrid() != nullptr) {
            MOTE_CHECK(i < scene.hybrids.size());
            plan.hybrids.push_back(planHybrid(*view.layers[i].hybrid(), view.layers[i].transform,
                                              scene.hybrids[i], plan.camera));
        }
        const ParticlesStyle* const style = view.layers[i].particles();
        if (style == nullptr) continue;
        plan.layers.push_back(planLayer(view.layers[i], *style, scene.steps[i], plan, quality, planning));
    }
    plan.dots = dotsOf(scene, plan);
    cutDepths(plan, std::max(1U, quality.slabs));
    return plan;
}

}  // namespace mote::render
