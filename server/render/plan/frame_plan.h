// SPDX-License-Identifier: GPL-3.0-or-later
//
// A FramePlan says what a device is to draw: primitives, which know nothing of the layers that they come
// from, and the depths and how they are cut. A value; layers/make_frame_plan.h makes it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "protocol/scene/camera.h"
#include "protocol/scene/view.h"
#include "server/render/plan/depth_sections.h"
#include "server/render/plan/dot.h"
#include "server/render/plan/field_plan.h"
#include "server/render/plan/fragment.h"
#include "server/render/plan/points_plan.h"
#include "server/render/plan/stroke.h"

namespace mote::render {

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
    bool exact = true;                      ///< Quality::exact(): not for a picture in motion
    std::vector<PointsPlan> points = {};    ///< at most View::maxLayers, and so are fields
    std::vector<FieldPlan> fields = {};     ///< those of densities, then those of grids
    std::shared_ptr<const Dots> dots = {};  ///< in pixels of the plan; null: none
    /// Pictures that drawings are made from, one list each; not null, not empty.
    std::vector<std::shared_ptr<const Fragments>> fragments = {};
    /// Highlighted points and what is seen of surfaces, made where it is drawn; not null.
    std::vector<std::shared_ptr<const FragmentMaker>> surfaces = {};
    /// What pens draw, in pixels of the plan, one list each; not null, not empty.
    std::vector<std::shared_ptr<const Strokes>> strokes = {};

    /// Whether anything stands at a depth of its own in a pixel: a dot, a fragment, a stroke.
    bool anyDots() const {
        return (dots != nullptr && !dots->empty()) || !fragments.empty() || !surfaces.empty() ||
               !strokes.empty();
    }
    /// How many fields are of densities.
    std::size_t densities() const {
        return static_cast<std::size_t>(
            std::count_if(fields.begin(), fields.end(), [](const auto& field) { return field.density(); }));
    }
    /// Nothing is in view but background.
    bool blank() const { return (points.empty() && fields.empty() && !anyDots()) || !(farDepth > nearDepth); }
    /// Whether any points wait for what is not in memory.
    bool waits() const {
        return std::any_of(points.begin(), points.end(), [](const auto& one) { return one.waits; });
    }
};

/// The depth from which on something is seen.
double nearLimit(const Camera& camera);

/// Box [0, 1]^3 to a plot's layer space [-1, 1]^3.
glm::dmat4 plotToLayer();

}  // namespace mote::render
