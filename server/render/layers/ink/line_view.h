// SPDX-License-Identifier: GPL-3.0-or-later
//
// LineView: a camera as lines are seen by it: from layer space to eye space to the picture, and the rays that
// tell whether a place is hidden. A value; pure.
#pragma once

#include <array>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "server/render/layers/mesh/mesh_rays.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

/// A share of a line, 0 at its beginning and 1 at its end; none if end < begin.
struct Span {
    double begin = 0.0, end = -1.0;

    bool empty() const { return !(begin <= end); }
};

class LineView {
  public:
    /// `plan`: its size and its camera are told.
    LineView(const FramePlan& plan, const glm::dmat4& transform);

    glm::dvec3 toEye(const glm::dvec3& inLayer) const;
    /// Pixels from the upper left corner; of what lies in front of the eye.
    glm::dvec2 onScreen(const glm::dvec3& inEye) const;
    /// Above 0 if the eye is on one side of a triangle in layer space, below 0 on the other; 0: edge-on.
    double facing(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) const;
    /// From a place in layer space, of length 1 there.
    glm::dvec3 wayToEye(const glm::dvec3& inLayer) const;
    /// The part of a line in eye space that lies in the picture, or up to `margin` pixels beside it, and is
    /// not too near.
    Span inPicture(const glm::dvec3& from, const glm::dvec3& to, double margin) const;
    /// Where along a line in eye space a share of its way on the screen lies.
    double alongLine(const glm::dvec3& from, const glm::dvec3& to, double onScreen) const;
    /// The reverse.
    double alongScreen(const glm::dvec3& from, const glm::dvec3& to, double alongLine) const;
    /// From a place in eye space to the eye, or to where nothing nearer is seen. `gap`: so much of the way,
    /// layer space, meets nothing.
    MeshRay towardsEye(const glm::dvec3& inEye, double gap) const;
    /// The same the other way, if that serves many places: from the eye of a perspective camera.
    MeshRay fromEye(const glm::dvec3& inEye, double gap) const;
    /// Through a place of the picture, told by depth from the eye.
    MeshRay through(const glm::dvec2& place) const;
    /// The part of a line in eye space that a triangle covers and lies in front of.
    Span hidden(const glm::dvec3& from, const glm::dvec3& to,
                const std::array<glm::dvec3, 3>& triangle) const;

    /// World units along the line of sight, of one of layer space in any direction, at most.
    double scale() const;
    bool perspective() const { return perspective_; }
    double nearest() const { return nearest_; }
    const glm::dvec2& size() const { return size_; }

  private:
    glm::dvec3 throughEye(const glm::dvec3& a, const glm::dvec3& b) const;

    bool perspective_;
    double nearest_;   // depth; nothing nearer is seen
    glm::dvec2 size_;  // of the picture, pixels
    double pixels_;    // a unit of the window
    glm::dmat4 toEye_, fromEye_;
    glm::dvec3 eye_;        // layer space; of a perspective camera
    glm::dvec3 direction_;  // towards the eye, layer space, of one unit of eye space; of an orthographic one
};

}  // namespace mote::render
