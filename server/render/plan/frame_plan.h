// SPDX-License-Identifier: GPL-3.0-or-later
//
// FramePlan: what a device is to draw, computed from scene and quality without a device: for each layer the
// points of each leaf that are drawn, the depths and how they are cut. A value that shares what does not
// depend on the camera; pure functions.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <memory>
#include <vector>

#include "server/render/layers/hybrid/hybrid_plan.h"
#include "server/render/plan/depth_sections.h"
#include "server/render/plan/point_selection.h"
#include "server/render/plan/preview_selection.h"
#include "server/render/plan/quality.h"
#include "server/render/plan/scene.h"
#include "server/render/plan/selection_cache.h"
#include "storage/particles/step_need.h"

namespace mote::render {

/// What is drawn of one layer.
struct LayerPlan {
    std::shared_ptr<const storage::ParticleStep> step;
    glm::dmat4 layerToEye{1.0};  ///< eye space: x right, y up, depth = -z
    ParticlesStyle style;  ///< opacity already raised for Quality::pointFraction; size in pixels of the plan
    std::shared_ptr<const PointSelection> selection;  ///< never null; of all leaves, also those out of view
    std::vector<std::uint64_t> leavesInView;          ///< as the function of that name: no bits, no limit
    /// In place of the leaves' points, of which none are selected then; null: there is none.
    std::shared_ptr<const PreviewSelection> preview;
    std::uint64_t pointsDrawn = 0;  ///< of the leaves that may be in view, or of the preview at most
    double share = 1.0;             ///< of the points of the exact picture; at most Quality::pointFraction
    storage::StepNeed need = {};    ///< what would have to be in memory for any share
    bool waits = false;  ///< the share is less than was asked for until what is needed is in memory

    /// How many of a leaf's points are drawn, from its first; 0 where it is known to be out of view.
    std::uint32_t drawn(std::size_t leaf) const {
        return leaf < selection->drawn.size() && inView(leavesInView, leaf) ? selection->drawn[leaf] : 0;
    }
};

struct FramePlan {
    std::uint32_t width = 0;  ///< pixels that are rendered
    std::uint32_t height = 0;
    Camera camera;
    glm::dvec3 background{0.0};  ///< linear RGB
    double nearDepth = 0.0;  ///< along the line of sight; all lies in [nearDepth, farDepth] that is drawn,
                             ///< but for dots without a depth
    double farDepth = 0.0;
    std::uint32_t slabs = 0;                  ///< of all sections
    std::vector<DepthSection> sections = {};  ///< front to back, from nearDepth to farDepth
    double samplesPerCell = 4.0;
    bool exact = true;              ///< Quality::exact(): not for a picture in motion
    std::vector<LayerPlan> layers;  ///< of particles
    std::vector<HybridPlan> hybrids = {};
    std::shared_ptr<const Dots> dots = {};  ///< in pixels of the plan; null: none

    bool anyDots() const { return dots != nullptr && !dots->empty(); }
    /// Nothing is in view but background.
    bool blank() const {
        return (layers.empty() && hybrids.empty() && !anyDots()) || !(farDepth > nearDepth);
    }
    /// Whether any layer does.
    bool waits() const;
};

/// Where points are drawn in front of a perspective eye at all: nothing nearer than this share of the
/// distance from the eye to the camera's target is seen, in every device and in the reference.
inline constexpr double nearShare = 1e-3;

/// Whether a plan takes the time to read what is not in memory. `notForPoints`: where the device can, it
/// shows of the points what the preview offers instead.
enum class Reading { all, notForPoints };

/// What a device knows to draw.
struct DeviceAbilities {
    bool preview = false;   ///< LayerPlan::preview
    bool allPoints = true;  ///< from this process's memory: LayerPlan::need asks for them
    bool hybrids = false;   ///< FramePlan::hybrids
};

/// Throws storage::StorageError where the octree's bytes are damaged.
FramePlan makeFramePlan(const Scene& scene, const Quality& quality, SelectionCache& selections,
                        DeviceAbilities device, Reading reading = Reading::all);
FramePlan makeFramePlan(const Scene& scene, const Quality& quality);

}  // namespace mote::render
