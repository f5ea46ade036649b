// SPDX-License-Identifier: GPL-3.0-or-later
//
// NearestTriangle: the place on a mesh that is nearest to a given one, by Embree's hierarchy of boxes.
// Move-only; any thread may ask.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>

#include "storage/mesh/surface_mesh.h"

namespace mote::test {

class NearestTriangle {
  public:
    struct Found {
        std::uint32_t triangle = 0;
        glm::dvec3 position{0.0};
        double distance = 0.0;  ///< world units
    };

    /// `mesh` must outlive it.
    explicit NearestTriangle(const storage::SurfaceMesh& mesh);
    NearestTriangle(NearestTriangle&&) noexcept;
    ~NearestTriangle();

    Found find(const glm::vec3& place) const;

  private:
    struct Scene;
    std::unique_ptr<Scene> scene_;
};

/// The place on a triangle that is nearest to a given one (Ericson, Real-Time Collision Detection, 5.1.5).
glm::dvec3 nearestOnTriangle(const glm::dvec3& place, const glm::dvec3& a, const glm::dvec3& b,
                             const glm::dvec3& c);

}  // namespace mote::test
