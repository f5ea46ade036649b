// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where the points of a step lie in its plot, and where a camera sees them. Values and pure functions.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>

#include "protocol/scene/camera.h"
#include "storage/particles/particle_step.h"

namespace mote::storage {

/// Goes through leaves in the order of their points; keeps octree and leaves in memory. The step outlives it.
class LeafWalk {
  public:
    /// Throws StorageError.
    explicit LeafWalk(const ParticleStep& step)
        : step_(&step), nodes_(step.nodes()), leaves_(step.leaves()) {}

    /// The leaf that holds a point of the step.
    std::size_t leafOf(std::uint64_t point) const;
    /// Layer space.
    struct Cell {
        glm::dvec3 low{0.0};  ///< its least corner
        double edge = 0.0;

        glm::dvec3 at(const PackedPosition& p) const {
            constexpr double part = 1.0 / 65536.0;
            return low + edge * (glm::dvec3(p.x, p.y, p.z) + 0.5) * part;
        }
    };
    Cell cell(std::size_t leaf) const { return cellOf(leaves_.node[leaf]); }
    /// A node's, whether it is a leaf or not.
    Cell cellOf(std::size_t node) const;

    const OctreeNodes& nodes() const { return nodes_; }
    const Leaves& leaves() const { return leaves_; }
    const ParticleStep& step() const { return *step_; }

  private:
    const ParticleStep* step_;
    OctreeNodes nodes_;
    Leaves leaves_;
};

/// Layer space to a picture of a camera, in double precision: docs/PICTURE.md, "Spaces".
class PictureMap {
  public:
    /// `aspect`: width over height.
    PictureMap(const Camera& camera, double aspect, const glm::dmat4& layerToWorld);

    struct Seen {
        double x, y;   ///< parts of the picture's width and height, y down; NaN where it is not seen
        double depth;  ///< along the line of sight
    };
    Seen operator()(const glm::dvec3& place) const {
        const auto row = [&](const glm::dvec4& r) {
            return r.x * place.x + r.y * place.y + r.z * place.z + r.w;
        };
        const double depth = row(depth_);
        if (depth < near_) {
            constexpr double nan = std::numeric_limits<double>::quiet_NaN();
            return {nan, nan, depth};
        }
        const double w = perspective_ ? depth : 1.0;
        return {0.5 + row(x_) / w, 0.5 + row(y_) / w, depth};
    }

  private:
    glm::dvec4 x_, y_, depth_;  // rows
    double near_;
    bool perspective_;
};

}  // namespace mote::storage
