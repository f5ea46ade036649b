// SPDX-License-Identifier: GPL-3.0-or-later
//
// MeshSight: a mesh layer as a plan's camera looks at it: rays through places of the picture, and what they
// see where they meet a triangle (docs/PICTURE.md, "Meshes"). Refers to the surface and the style; any number
// of threads. By it a mesh layer becomes fragments.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>

#include "protocol/scene/view.h"
#include "server/render/layers/lowering.h"
#include "server/render/layers/mesh/mesh_surface.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

/// A ray through a place of the picture; told by depth, from where all of a sight begin.
struct SightRay {
    glm::dvec2 window{0.0};  ///< where it meets the plane at depth 1 (perspective) or any (orthographic)
    MeshRay inLayer;
};

/// A surface where a ray meets it.
struct MeshHit {
    double depth;
    glm::dvec3 color;   ///< linear RGB
    glm::dvec3 normal;  ///< eye space, unit, on the side that is seen
};

class MeshSight {
  public:
    /// `plan`: its size and its camera are told. `pixels`: of the plan, a pixel of the view. `clips`: what of
    /// the mesh they cut away is not there, nor does it cast a shadow.
    MeshSight(const FramePlan& plan, const glm::dmat4& transform, const MeshStyle& style,
              const MeshSurface& surface, double pixels, HalfSpaces clips = {});

    /// Through (x, y) of the picture, in pixels from its upper left corner.
    SightRay through(double x, double y) const;
    /// What the ray sees where it meets the mesh; nothing between the lines of a wire.
    std::optional<MeshHit> hit(const SightRay& ray, const MeshMeeting& met) const;

    /// Pixels that the mesh may touch.
    PixelRect touched() const;
    /// Depths between which the mesh lies, nothing nearer than what is seen.
    double nearDepth() const { return nearDepth_; }
    double farDepth() const { return farDepth_; }

  private:
    struct Corners;
    bool onWire(const glm::dvec2& window, const Corners& corners) const;
    glm::dvec3 shade(const glm::dvec3& normal, const glm::dvec3& towardsEye, bool shadowed) const;
    bool shadowed(const glm::dvec3& place, const glm::dvec3& side) const;

    glm::dvec3 color_;  // linear RGB
    bool wire_;
    Light parts_;  // its direction apart
    const MeshSurface& surface_;
    HalfSpaces clips_;
    bool perspective_;
    double nearest_;   // depth; nothing nearer is seen
    glm::dvec2 size_;  // of the picture, pixels
    double pixels_;    // a unit of the window
    double halfLine_;  // of a wire, pixels
    glm::dmat4 toEye_, fromEye_;
    glm::dmat3 areaToEye_;     // normals times areas, layer to eye space
    glm::dvec3 light_;         // towards it, eye space, unit
    glm::dvec3 lightInLayer_;  // the same, layer space
    double shadowGap_;         // layer space
    double nearDepth_, farDepth_;
    double start_;  // depth at which rays begin: near the mesh, so that their digits are told from there
};

/// The layer's fragments are made where they are drawn.
void lowerMesh(const Layer& layer, const MeshStyle& style, std::shared_ptr<const MeshSurface> surface,
               Lowering& out);

}  // namespace mote::render
