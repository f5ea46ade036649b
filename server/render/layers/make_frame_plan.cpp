// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/make_frame_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

#include "protocol/base/mote_check.h"
#include "server/render/layers/contrast/lower_contrast.h"
#include "server/render/layers/hybrid/lower_hybrid.h"
#include "server/render/layers/image/lower_image.h"
#include "server/render/layers/ink/lower_ink.h"
#include "server/render/layers/lowering.h"
#include "server/render/layers/mesh/mesh_sight.h"
#include "server/render/layers/particles/lower_particles.h"

namespace mote::render {
namespace {

std::uint32_t scaledSide(std::uint32_t pixels, double scale) {
    return std::max(1U, static_cast<std::uint32_t>(std::lround(pixels * scale)));
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

/// Least and greatest of all depths, of areas also beside what is inked; the first is greater where there are
/// none.
std::pair<double, double> depthsOf(const Strokes& strokes) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    const auto add = [&](double depth) {
        low = std::min(low, depth);
        high = std::max(high, depth);
    };
    for (const auto& line : strokes.lines) {
        for (auto i = line.begin; i < line.end; ++i) add(strokes.points[i].depth);
    }
    for (const float depth : strokes.areaDepths.values) {
        if (std::isfinite(depth)) add(static_cast<double>(depth));
    }
    return {low, high};
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

/// In a very wide picture the rays at its corners go through a slab slantwise, and a box may lie in one slab
/// of theirs: beyond 60 degrees slabs are cut as much finer as the way through one is longer.
std::uint32_t slabsFor(const FramePlan& plan, std::uint32_t slabs) {
    if (!plan.camera.perspective()) return slabs;
    const double up = plan.camera.halfHeight(), right = up * plan.width / plan.height;
    const double way = 0.5 * std::sqrt(1.0 + right * right + up * up);
    return std::max(slabs, static_cast<std::uint32_t>(std::min<double>(slabs * way, mostSlabs)));
}

/// Cuts all depths at which something can be seen; none where there are none.
void cutDepths(FramePlan& plan, std::vector<DepthRange> depths) {
    for (auto& range : depths) range.nearDepth = std::max(range.nearDepth, nearLimit(plan.camera));
    plan.sections = depthSections(depths);
    if (plan.sections.empty()) return;
    plan.nearDepth = plan.sections.front().nearDepth;
    plan.farDepth = plan.sections.back().farDepth;
    plan.slabs = plan.sections.back().endSlab();
}

/// The kinds of layers that lower to primitives here; stipples are dots already.
struct LayerLowering {
    const Scene& scene;
    std::size_t index;
    Lowering& out;

    const Layer& layer() const { return scene.view.layers[index]; }
    const LayerData& data() const { return scene.layers[index]; }
    void operator()(const proto::ParticlesStyle&) const { lowerParticles(scene, index, out); }
    void operator()(const proto::HybridStyle& style) const {
        lowerHybrid(layer(), index, hybridStyleOf(style), data().hybrid, out);
    }
    void operator()(const StippleStyle&) const {}
    void operator()(const proto::InkStyle& message) const {
        out.last.emplace_back([&layer = layer(), style = inkStyleOf(message, layer().inkIsDark),
                               drawn = inkDataOf(layer(), data()), memory = data().ink.get(),
                               &out = out] { lowerInk(layer, style, drawn, memory, out); });
    }
    void operator()(const MeshStyle& style) const {
        out.last.emplace_back([&layer = layer(), &style, surface = data().mesh, &out = out] {
            lowerMesh(layer, style, surface, out);
        });
    }
    void operator()(const proto::ImageStyle&) const {
        // Those of the same depth lie behind one another as they are listed, and later images over earlier.
        out.last.emplace(out.last.begin(), [&layer = layer(), image = data().image, &out = out] {
            lowerImage(layer, image, out);
        });
    }
};

}  // namespace

void Lowering::addBox(const Bounds& inEye) {
    const double low = -inEye.max.z, high = -inEye.min.z;
    // Never of no length, which rounding may make of what is far away.
    const double margin = 1e-12 * std::max(std::abs(low), std::abs(high));
    depths.push_back(high - low > 2.0 * margin ? DepthRange{low, high, slabs}
                                               : DepthRange{low - margin, high + margin, slabs});
}

/// A little more, so that there is a range where all dots have one depth, or none: then where it is seen.
void Lowering::addDots(double nearest, double farthest) {
    const double low = std::max(nearest, nearLimit(plan.camera));
    const double high = std::max(farthest, nearLimit(plan.camera));
    depths.push_back({low - 1e-6 * (1.0 + std::abs(low)), high + 1e-6 * (1.0 + std::abs(high)), 0});
}

/// The same opacities over a longer way: no value that is seen is lost, however little there is of it.
TransferFunction thinned(TransferFunction transfer, double opacity) {
    constexpr double least = 1e-12;  // of which no picture shows anything
    transfer.opacityLength /= std::max(opacity, least);
    return transfer;
}

FramePlan makeFramePlan(const Scene& scene, const Quality& quality) {
    SelectionCache selections;
    return makeFramePlan(scene, quality, selections, {});
}

FramePlan makeFramePlan(const Scene& scene, const Quality& quality, SelectionCache& selections,
                        DeviceAbilities device, Reading reading, const std::stop_token& stop) {
    MOTE_CHECK(scene.layers.size() == scene.view.layers.size());
    MOTE_CHECK(quality.resolutionScale > 0.0 && quality.resolutionScale <= 1.0);
    MOTE_CHECK(quality.pointFraction > 0.0 && quality.pointFraction <= 1.0);
    const View& view = scene.view;
    FramePlan plan{.width = scaledSide(view.width, quality.resolutionScale),
                   .height = scaledSide(view.height, quality.resolutionScale),
                   .camera = view.camera,
                   .background = view.background,
                   .samplesPerCell = quality.samplesPerCell,
                   .exact = quality == Quality::exact()};
    Lowering lowering{.plan = plan,
                      .quality = quality,
                      .selections = selections,
                      .device = device,
                      .reading = reading,
                      .pixels = static_cast<double>(plan.height) / view.height,
                      .slabs = slabsFor(plan, std::max(1U, quality.slabs)),
                      .stop = stop};
    for (std::size_t i = 0; i < view.layers.size(); ++i) {
        // Of what there is nothing of there need not be any data either.
        if (view.layers[i].opacity > 0.0) std::visit(LayerLowering{scene, i, lowering}, view.layers[i].style);
    }
    for (const auto& lower : lowering.highlights) {
        if (!plan.exact || !plan.waits()) lower();
    }
    for (const auto& lower : lowering.last) {
        if (!plan.exact || !plan.waits()) lower();
    }
    if (!plan.exact || !plan.waits()) {
        if (auto contrast = depthContrastOf(scene, plan, stop)) plan.surfaces.push_back(std::move(contrast));
    }
    std::stable_partition(plan.fields.begin(), plan.fields.end(),
                          [](const FieldPlan& field) { return field.density() != nullptr; });
    plan.dots = dotsOf(scene, plan);
    if (plan.dots && !plan.dots->empty()) {
        const auto [first, last] = finiteDepths(*plan.dots);
        lowering.addDots(first, last);
    }
    for (const auto& strokes : plan.strokes) {
        const auto [first, last] = depthsOf(*strokes);
        if (first <= last) lowering.addDots(first, last);
    }
    cutDepths(plan, std::move(lowering.depths));
    return plan;
}

}  // namespace mote::render
