// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/find_intersections.h"

#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <glm/common.hpp>

#include "preprocess/mesh/surface_topology.h"
#include "storage/mesh/triangle_intersection.h"

namespace mote::prep {
namespace {

constexpr std::uint64_t leastBoxPairs = 100'000'000, boxPairsPerTriangle = 32;
constexpr std::uint64_t leastCuts = 4'000'000, cutsPerTriangle = 8;
constexpr std::uint64_t pairsPerQuestion = 65536;  // whether it is cancelled

using TrianglePair = std::array<std::uint32_t, 2>;
using TriangleBox = CGAL::Box_intersection_d::Box_with_handle_d<float, 3, const std::array<std::uint32_t, 3>*,
                                                                CGAL::Box_intersection_d::ID_FROM_HANDLE>;

/// Thrown through CGAL's search, which has no other end.
struct SearchEnd {};

class IntersectionFinder {
  public:
    IntersectionFinder(const storage::SurfaceMesh& mesh, const std::function<bool()>& cancelled)
        : mesh_(mesh), cancelled_(cancelled), rule_(mesh), neighbours_(neighboursOf(mesh)) {}

    /// Throws SearchEnd.
    std::vector<TrianglePair> find() {
        auto boxes = boxesOf();
        CGAL::box_self_intersection_d(boxes.begin(), boxes.end(),
                                      [&](const TriangleBox& a, const TriangleBox& b) { look(a, b); });
        std::sort(found_.begin(), found_.end());
        return std::move(found_);
    }

  private:
    std::vector<TriangleBox> boxesOf() const {
        const auto margin = static_cast<float>(rule_.tolerance());
        std::vector<TriangleBox> boxes;
        boxes.reserve(mesh_.triangles.size());
        for (const auto& triangle : mesh_.triangles) {
            const auto &a = mesh_.positions[triangle[0]], &b = mesh_.positions[triangle[1]],
                       &c = mesh_.positions[triangle[2]];
            auto low = glm::min(glm::min(a, b), c) - margin, high = glm::max(glm::max(a, b), c) + margin;
            boxes.emplace_back(&low.x, &high.x, &triangle);
        }
        return boxes;
    }
    void look(const TriangleBox& a, const TriangleBox& b) {
        if (++looked_ > leastBoxPairs + boxPairsPerTriangle * mesh_.triangles.size()) throw SearchEnd();
        if (looked_ % pairsPerQuestion == 0 && cancelled_()) throw SearchEnd();
        const auto [one, other] = std::minmax({numberOf(a), numberOf(b)});
        if (!rule_.between(one, other) || leansOn(one, other) || leansOn(other, one)) return;
        if (found_.size() >= leastCuts + cutsPerTriangle * mesh_.triangles.size()) throw SearchEnd();
        found_.push_back({one, other});
    }
    std::uint32_t numberOf(const TriangleBox& box) const {
        return static_cast<std::uint32_t>(box.handle() - mesh_.triangles.data());
    }
    /// Whether an edge of a triangle lies in another one's plane, and the surface does not go through it
    /// there.
    bool leansOn(std::uint32_t triangle, std::uint32_t plane) const {
        const auto heights = rule_.heights(triangle, plane);
        for (std::size_t i = 0; i < 3; ++i) {
            if (heights[i] != 0.0 || heights[(i + 1) % 3] != 0.0) continue;
            const auto beyond = neighbours_[triangle][i];
            if (beyond == storage::MeshEdge::none) return true;
            const auto there = rule_.heights(beyond, plane);
            return *std::max_element(there.begin(), there.end()) <= 0.0;
        }
        return false;
    }

    const storage::SurfaceMesh& mesh_;
    const std::function<bool()>& cancelled_;
    const storage::TriangleIntersections rule_;
    const TriangleNeighbours neighbours_;
    std::uint64_t looked_ = 0;
    std::vector<TrianglePair> found_;
};

}  // namespace

std::optional<std::vector<TrianglePair>> findIntersections(const storage::SurfaceMesh& mesh,
                                                           const std::function<bool()>& cancelled) {
    try {
        return IntersectionFinder(mesh, cancelled).find();
    } catch (const SearchEnd&) {
        return std::nullopt;
    }
}

}  // namespace mote::prep
