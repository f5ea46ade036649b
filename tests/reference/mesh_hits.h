// SPDX-License-Identifier: GPL-3.0-or-later
//
// MeshHits: what a mesh layer is in each pixel (docs/PICTURE.md, "Meshes"): every triangle tried for every
// sample, in eye space, in double precision. Made once for a picture; immutable, safe on any number of
// threads.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <vector>

#include "protocol/scene/view.h"
#include "server/render/layers/mesh/mesh_surface.h"
#include "tests/reference/hit.h"

namespace mote::reference {

class MeshHits {
  public:
    MeshHits(const View& view, const Layer& layer, const render::MeshSurface& surface);

    /// Appends the hits of a row of pixels, column by column, front to back. Each hides as much of what is
    /// left of the pixel's light as the sample that meets it loses.
    void addRow(std::uint32_t row, std::vector<Hit>& hits) const;

  private:
    struct Triangle {
        std::array<glm::dvec3, 3> corners;  ///< eye space
        std::array<glm::dvec3, 3> inWindow;
        std::array<glm::dvec3, 3> inLayer;
        std::array<glm::dvec3, 3> normals;  ///< eye space
        glm::dvec2 low, high;               ///< pixels that it may touch
    };
    struct Met {
        double depth;
        std::size_t sample;
        glm::dvec3 color;
    };

    Triangle triangleOf(const storage::SurfaceMesh& mesh, const std::array<std::uint32_t, 3>& vertices) const;
    void meet(const Triangle& triangle, const glm::dvec2& at, std::size_t sample,
              std::vector<Met>& met) const;
    void addPixel(std::uint32_t column, std::uint32_t row, const std::vector<const Triangle*>& near,
                  std::vector<Hit>& hits) const;
    bool nearEdge(const Triangle& triangle, const glm::dvec3& window) const;
    bool inShadow(const glm::dvec3& place) const;
    glm::dvec3 shade(const glm::dvec3& normal, const glm::dvec3& towardsEye, bool dark) const;

    const View& view_;
    const Layer& layer_;
    const MeshStyle& style_;
    Light shading_;
    glm::dvec3 color_;  // linear RGB
    double halfWire_;   // pixels
    double opacity_;    // of a surface
    glm::dmat4 toEye_;
    double gap_;  // off the surface, where rays to the light begin
    double pixels_;
    glm::dvec3 light_, lightInLayer_;
    std::vector<Triangle> triangles_;
};

}  // namespace mote::reference
