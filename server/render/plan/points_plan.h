// SPDX-License-Identifier: GPL-3.0-or-later
//
// A PointsPlan is points that a device is to draw, all of one size, opacity and colour: some of each leaf of
// a step, or some of its preview. A value that shares what does not depend on the camera; part of a
// FramePlan.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/scene/clip.h"
#include "server/render/plan/frustum.h"
#include "server/render/plan/point_selection.h"
#include "server/render/plan/point_values.h"
#include "server/render/plan/preview_selection.h"
#include "storage/particles/particle_step.h"

namespace mote::render {

/// The look of a point.
struct PointLook {
    double size = 1.0;     ///< diameter, pixels of the plan
    double opacity = 1.0;  ///< 0 to TransferFunction::opacityLimit; where there is no `light`
    /// Above 0: what points hide belongs to the world, not to pixels. The optical depth of a whole point that
    /// weighs 1, seen by an orthographic eye; by a perspective one times the square of its depth.
    double light = 0.0;
    glm::dvec3 color{1.0};  ///< linear RGB
    /// What is left of its optical depth in each pixel (docs/PICTURE.md, "Layers that fade"), above 0, at
    /// most 1.
    double thinned = 1.0;

    /// Optical depth of a whole point that weighs 1, at a depth, before it is thinned; in its only pixel,
    /// where it is no larger.
    double tauAt(double depth, bool perspective) const {
        if (light > 0.0) return perspective ? light / (depth * depth) : light;
        const double inPixel = std::min(size, 1.0);
        return -std::log1p(-opacity * inPixel * inPixel);
    }
    /// What discs are spread by: optical depth is in proportion to coverage where this is 0.
    double discOpacity() const { return light > 0.0 ? 0.0 : opacity; }
    bool operator==(const PointLook&) const = default;
};

struct PointsPlan {
    std::size_t layer = 0;  ///< the one of the view that they are of
    std::shared_ptr<const storage::ParticleStep> step = {};
    /// Whose points they are, where they are drawn at other places than it has them at; null: `step`'s.
    std::shared_ptr<const storage::ParticleStep> source = {};
    HalfSpaces clips = {};     ///< that cut `step` out of it, layer space; none: nothing was cut away
    glm::dmat4 boxToEye{1.0};  ///< the plot's box [0, 1]^3 to eye space
    PointLook look = {};
    Curve fraction = Curve::constant(1.0);  ///< t -> how much of a leaf's points is drawn, before `share`
    std::shared_ptr<const StepVolume> volume = {};  ///< the layer's: PointChoice
    double meanWeight = 0.0;
    Thinning thinning = {};  ///< these too: PointChoice
    std::shared_ptr<const PointSelection> selection =
        {};                                        ///< never null; of all leaves, also those out of view
    std::vector<std::uint64_t> leavesInView = {};  ///< as the function of that name: no bits, no limit
    /// Drawn in place of the leaves' points, of which none are selected then; null: there is none.
    std::shared_ptr<const PreviewSelection> preview = {};
    std::uint64_t pointsDrawn = 0;  ///< of the leaves that may be in view, or of the preview at most
    double share = 1.0;             ///< of the points of the exact picture; at most Quality::pointFraction
    storage::StepNeed need = {};    ///< what of the source would have to be in memory for any share
    std::optional<PointColors> colors = {};  ///< in place of the look's, where a pixel has a value
    bool waits = false;  ///< the share is less than was asked for until what is needed is in memory

    PointChoice choice() const {
        return {fraction, share, volume, meanWeight, thinning, colors ? colors->shade : std::nullopt};
    }
    /// Whether all points of the picture hide alike, wherever they are.
    bool alike(bool perspective) const {
        return look.light == 0.0 || (!perspective && selection->weights.empty());
    }
    /// How many of a leaf's points are drawn, from its first; 0 where it is known to be out of view.
    std::uint32_t drawn(std::size_t leaf) const {
        return leaf < selection->drawn.size() && inView(leavesInView, leaf) ? selection->drawn[leaf] : 0;
    }
};

}  // namespace mote::render
