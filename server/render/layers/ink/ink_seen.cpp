// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/ink_seen.h"

#include <utility>

#include "server/render/layers/ink/line_view.h"
#include "server/render/layers/ink/mesh_lines.h"
#include "server/render/layers/ink/mesh_modalities.h"
#include "server/render/layers/ink/volume_lines.h"
#include "server/render/layers/ink/volume_modalities.h"

namespace mote::render {
namespace {

// Pixels between places of a line at which what hides it is sought, at rest and in motion.
constexpr double exactSampling = 0.35, quickSampling = 2.0;

/// Sees one kind of data or the other.
struct Seeing {
    const glm::dmat4& transform;
    const InkStyle& style;
    const FramePlan& plan;
    const bool lines;
    const std::stop_token& stop;

    InkScene operator()(const std::shared_ptr<const MeshSurface>& surface) const {
        auto seen = modalitiesOf(*surface, transform, style, plan, stop);
        InkScene scene{std::move(seen.modalities), {}};
        if (!lines) return scene;
        const LineView view(plan, transform);
        const auto edges = linesOf(*surface, view, style.silhouettes.crease, stop);
        const auto pieces =
            visible(*surface, view, edges,
                    {.sampling = plan.exact ? exactSampling : quickSampling, .likely = &seen.triangle}, stop);
        scene.lines = chained(*surface, view, pieces, scene.modalities.extent, stop);
        return scene;
    }
    InkScene operator()(const InkVolume& volume) const {
        auto seen = modalitiesOf(volume, transform, style, plan, stop);
        InkScene scene;
        if (lines && !stop.stop_requested()) scene.lines = linesOf(seen, stop);
        scene.modalities = std::move(seen.modalities);
        return scene;
    }
};

}  // namespace

InkScene seenOf(const InkData& data, const glm::dmat4& transform, const InkStyle& style,
                const FramePlan& plan, bool lines, const std::stop_token& stop) {
    return std::visit(Seeing{transform, style, plan, lines, stop}, data);
}

}  // namespace mote::render
