// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/ink_seen.h"

#include <optional>
#include <utility>

#include "server/render/layers/ink/line_view.h"
#include "server/render/layers/ink/mesh_chains.h"
#include "server/render/layers/ink/mesh_lines.h"
#include "server/render/layers/ink/mesh_modalities.h"
#include "server/render/layers/ink/quick_lines.h"
#include "server/render/layers/ink/visible_lines.h"
#include "server/render/layers/ink/volume_lines.h"
#include "server/render/layers/ink/volume_modalities.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

// Pixels between places of a line at which what hides it is sought.
constexpr double sampling = 0.35;

/// Whether a drawing chooses lines by the depth steps beside them.
bool needsSteps(const InkStyle& style) {
    const auto mode = style.silhouettes.mode;
    return mode == SilhouetteMode::important || mode == SilhouetteMode::adjusted ||
           style.solid.strength > 0.0;
}

/// Sees one kind of data or the other.
struct Seeing {
    const glm::dmat4& transform;
    const InkStyle& style;
    const FramePlan& plan;
    const bool lines;
    const std::stop_token& stop;

    InkScene operator()(const std::shared_ptr<const MeshSurface>& surface) const {
        auto seen = modalitiesOf(*surface, transform, style, plan, stop);
        InkScene scene;
        scene.modalities = std::move(seen.modalities);
        if (!lines) return scene;
        const LineView view(plan, transform);
        const auto edges = linesOf(*surface, view, style.silhouettes.crease, stop);
        if (!plan.exact) {
            scene.quick = true;
            scene.lines = quickLines(*surface, view, edges, scene.modalities, stop);
            return scene;
        }
        const auto pieces =
            visible(*surface, view, edges,
                    {.sampling = sampling, .likely = &seen.triangle, .farthest = &seen.farthest}, stop);
        scene.lines =
            chained(*surface, view, pieces,
                    needsSteps(style) ? std::optional(scene.modalities.extent) : std::nullopt, stop);
        return scene;
    }
    InkScene operator()(const InkVolume& volume) const {
        auto seen = modalitiesOf(volume, transform, style, plan, stop);
        InkScene scene;
        if (lines && !isStopped(stop)) scene.lines = linesOf(seen, stop);
        scene.modalities = std::move(seen.modalities);
        return scene;
    }
};

}  // namespace

InkScene seenOf(const InkData& data, const glm::dmat4& transform, const InkStyle& style,
                const FramePlan& plan, bool lines, const std::stop_token& stop) {
    auto scene = std::visit(Seeing{transform, style, plan, lines, stop}, data);
    scene.camera = {.toEye = plan.camera.worldToEye() * transform,
                    .perspective = plan.camera.perspective(),
                    .pixels = plan.height / (2.0 * plan.camera.halfHeight()),
                    .size = {plan.width, plan.height}};
    return scene;
}

}  // namespace mote::render
