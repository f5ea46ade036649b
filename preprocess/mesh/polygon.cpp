// SPDX-License-Identifier: GPL-3.0-or-later
#include <glm/geometric.hpp>

#include "preprocess/mesh/large_polygon.h"
#include "preprocess/mesh/triangle_mesh.h"

namespace mote::prep {
namespace {

constexpr std::size_t mostEars = 64;

/// Newell's normal: twice the area of the polygon's shadow on each coordinate plane.
glm::dvec3 normalOf(const ExactMesh& mesh, std::span<const std::uint32_t> corners) {
    glm::dvec3 sum(0.0);
    const glm::dvec3 first = mesh.positions[corners[0]];  // far from 0, products lose what is small
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 a = mesh.positions[corners[i]] - first;
        const glm::dvec3 b = mesh.positions[corners[(i + 1) % corners.size()]] - first;
        sum += glm::cross(a, b);
    }
    return sum;
}

class Ears {
  public:
    Ears(ExactMesh& mesh, std::span<const std::uint32_t> corners)
        : mesh_(mesh), normal_(normalOf(mesh, corners)), left_(corners.begin(), corners.end()) {}

    void cut() {
        while (left_.size() > 3) {
            std::size_t ear = 0;
            while (ear < left_.size() && !isEar(ear)) ++ear;
            // No ear: it crosses itself or has no area. Any triangle is as good as another.
            if (ear == left_.size()) ear = 1;
            mesh_.triangles.push_back({corner(ear + left_.size() - 1), corner(ear), corner(ear + 1)});
            left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(ear));
        }
        mesh_.triangles.push_back({left_[0], left_[1], left_[2]});
    }

  private:
    std::uint32_t corner(std::size_t i) const { return left_[i % left_.size()]; }
    double side(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
        const glm::dvec3 origin = mesh_.positions[a];
        return glm::dot(glm::cross(mesh_.positions[b] - origin, mesh_.positions[c] - origin), normal_);
    }
    bool isEar(std::size_t i) const {
        const auto a = corner(i + left_.size() - 1);
        const auto b = corner(i);
        const auto c = corner(i + 1);
        if (!(side(a, b, c) > 0.0)) return false;
        for (const auto other : left_) {
            if (other == a || other == b || other == c) continue;
            if (side(a, b, other) >= 0.0 && side(b, c, other) >= 0.0 && side(c, a, other) >= 0.0)
                return false;
        }
        return true;
    }

    ExactMesh& mesh_;
    glm::dvec3 normal_;
    std::vector<std::uint32_t> left_;
};

}  // namespace

void addPolygon(ExactMesh& mesh, std::span<const std::uint32_t> corners) {
    if (corners.size() < 3) {
        ++mesh.smallFaces;
    } else if (corners.size() == 3) {
        mesh.triangles.push_back({corners[0], corners[1], corners[2]});
    } else if (corners.size() <= mostEars) {
        Ears(mesh, corners).cut();
    } else {
        cutLargePolygon(mesh, corners, normalOf(mesh, corners));
    }
}

}  // namespace mote::prep
