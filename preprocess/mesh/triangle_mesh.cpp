// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/triangle_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "preprocess/particles/cell_plan.h"
#include "storage/places.h"

namespace mote::prep {
namespace {

constexpr double cellsAcross = 2097151.0;  // 2^21 - 1, of the box's longest side

glm::dvec3 middle(const TriangleMesh& mesh, const Triangle& triangle) {
    return (glm::dvec3(mesh.positions[triangle[0]]) + glm::dvec3(mesh.positions[triangle[1]]) +
            glm::dvec3(mesh.positions[triangle[2]])) /
           3.0;
}

/// Of each triangle, its key and its number.
template <class T>
std::vector<T> inOrder(const std::vector<T>& values,
                       const std::vector<std::pair<std::uint64_t, std::uint32_t>>& keyed) {
    std::vector<T> made;
    made.reserve(values.size());
    for (const auto& [key, triangle] : keyed) made.push_back(values[triangle]);
    return made;
}

constexpr std::uint32_t noVertex = std::numeric_limits<std::uint32_t>::max();
constexpr double leastHeight = 1e-7;   // of the longest edge
constexpr double needleHeight = 1e-3;  // of the longest edge

/// The first vertex at each vertex's place; none if it is no place.
std::vector<std::uint32_t> firstAtPlace(const std::vector<glm::vec3>& positions) {
    std::vector<std::uint32_t> order;
    order.reserve(positions.size());
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
        if (storage::isPlace(positions[i])) order.push_back(i);
    }
    const auto place = [&](std::uint32_t i) {
        return std::tuple(positions[i].x, positions[i].y, positions[i].z);
    };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tuple(place(a), a) < std::tuple(place(b), b);
    });
    std::vector<std::uint32_t> first(positions.size(), noVertex);
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool again = i > 0 && place(order[i]) == place(order[i - 1]);
        first[order[i]] = again ? first[order[i - 1]] : order[i];
    }
    return first;
}

/// Height over the longest edge; 0 where that has no length.
double heightOf(const TriangleMesh& mesh, const Triangle& triangle) {
    const glm::dvec3 a(mesh.positions[triangle[0]]);
    const glm::dvec3 b(mesh.positions[triangle[1]]);
    const glm::dvec3 c(mesh.positions[triangle[2]]);
    const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
    if (!(longest > 0.0)) return 0.0;
    const double height = glm::length(glm::cross((b - a) / longest, (c - a) / longest));
    return std::isfinite(height) ? height : 0.0;
}

Triangle sorted(Triangle triangle) {
    std::sort(triangle.begin(), triangle.end());
    return triangle;
}

/// Moves triangle `from`, with its part, to the place of one that is left out.
void keep(TriangleMesh& mesh, std::size_t from, std::size_t to) {
    mesh.triangles[to] = mesh.triangles[from];
    if (!mesh.parts.empty()) mesh.parts[to] = mesh.parts[from];
}

void keepFirst(TriangleMesh& mesh, std::size_t count) {
    mesh.triangles.resize(count);
    if (!mesh.parts.empty()) mesh.parts.resize(count);
}

void removeRepeated(TriangleMesh& mesh, MeshCounts& counts) {
    const auto& triangles = mesh.triangles;
    std::vector<std::uint32_t> order(triangles.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tuple(sorted(triangles[a]), a) < std::tuple(sorted(triangles[b]), b);
    });
    std::vector<bool> repeated(triangles.size());
    for (std::size_t i = 1; i < order.size(); ++i) {
        repeated[order[i]] = sorted(triangles[order[i]]) == sorted(triangles[order[i - 1]]);
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (!repeated[i]) keep(mesh, i, kept++);
    }
    counts.repeated += triangles.size() - kept;
    keepFirst(mesh, kept);
}

void removeUnused(TriangleMesh& mesh) {
    std::vector<std::uint32_t> renamed(mesh.positions.size(), noVertex);
    for (const auto& triangle : mesh.triangles) {
        for (const auto corner : triangle) renamed[corner] = 0;
    }
    std::uint32_t kept = 0;
    for (std::size_t i = 0; i < renamed.size(); ++i) {
        if (renamed[i] == noVertex) continue;
        mesh.positions[kept] = mesh.positions[i];
        renamed[i] = kept++;
    }
    mesh.positions.resize(kept);
    for (auto& triangle : mesh.triangles) {
        for (auto& corner : triangle) corner = renamed[corner];
    }
}

constexpr double floatStep = 0x1p-23;   // of a number, over it
constexpr double greatestStep = 1e-5;   // over the longest side
constexpr double greatestPlace = 1e18;  // what lies further is left out later (storage/places.h)

bool isNear(const glm::dvec3& place) {
    return std::abs(place.x) < greatestPlace && std::abs(place.y) < greatestPlace &&
           std::abs(place.z) < greatestPlace;
}

// Polygons of very many corners, cut into triangles by their ears, too, but with a grid of the corners that
// may lie in one. A function without state.

constexpr std::uint64_t mostCutting = std::uint64_t{1}
                                      << 31;  // corners and cells looked at, in a mesh: some seconds

double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// The corners in the plane of the coordinates that the polygon covers most of, counterclockwise.
std::vector<glm::dvec2> flattened(const ExactMesh& mesh, std::span<const std::uint32_t> corners,
                                  const glm::dvec3& normal) {
    int axis = 0;
    for (int i = 1; i < 3; ++i) axis = std::abs(normal[i]) > std::abs(normal[axis]) ? i : axis;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const glm::dvec3 first = mesh.positions[corners[0]];
    std::vector<glm::dvec2> places;
    places.reserve(corners.size());
    for (const auto corner : corners) {
        const glm::dvec3 place = mesh.positions[corner] - first;
        places.emplace_back(normal[axis] < 0.0 ? -place[u] : place[u], place[v]);
    }
    return places;
}

/// Corners that turn the other way, in square cells.
class ReflexGrid {
  public:
    explicit ReflexGrid(const std::vector<glm::dvec2>& places) : places_(places) {
        glm::dvec2 high(-std::numeric_limits<double>::infinity());
        low_ = -high;
        for (const auto& place : places) {
            low_ = glm::min(low_, place);
            high = glm::max(high, place);
        }
        side_ = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(places.size()))));
        const glm::dvec2 span = high - low_;
        scale_ = glm::dvec2(span.x > 0.0 ? side_ / span.x : 0.0, span.y > 0.0 ? side_ / span.y : 0.0);
        cells_.resize(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
    }
    void add(std::uint32_t corner) { cellAt(places_[corner]).push_back(corner); }
    void remove(std::uint32_t corner) {
        auto& cell = cellAt(places_[corner]);
        cell.erase(std::remove(cell.begin(), cell.end(), corner), cell.end());
    }
    /// Whether `holds` is true of one of those near a triangle. Adds to `work` what that took.
    template <class Holds>
    bool anyNear(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, std::uint64_t& work,
                 Holds holds) const {
        const glm::ivec2 from = index(glm::min(a, glm::min(b, c))), to = index(glm::max(a, glm::max(b, c)));
        for (int y = from.y; y <= to.y; ++y) {
            for (int x = from.x; x <= to.x; ++x) {
                const auto& cell = cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) +
                                          static_cast<std::size_t>(x)];
                work += 1 + cell.size();
                if (std::any_of(cell.begin(), cell.end(), holds)) return true;
            }
        }
        return false;
    }

  private:
    glm::ivec2 index(const glm::dvec2& place) const {
        const glm::dvec2 at = (place - low_) * scale_;
        const auto bounded = [&](double x) {
            return x > 0.0 ? static_cast<int>(std::min(x, side_ - 1.0)) : 0;
        };
        return {bounded(at.x), bounded(at.y)};
    }
    std::vector<std::uint32_t>& cellAt(const glm::dvec2& place) {
        const auto at = index(place);
        return cells_[static_cast<std::size_t>(at.y) * static_cast<std::size_t>(side_) +
                      static_cast<std::size_t>(at.x)];
    }

    const std::vector<glm::dvec2>& places_;
    glm::dvec2 low_, scale_{0.0};
    int side_ = 1;
    std::vector<std::vector<std::uint32_t>> cells_;
};

class LargePolygon {
  public:
    LargePolygon(ExactMesh& mesh, std::span<const std::uint32_t> corners, const glm::dvec3& normal)
        : mesh_(mesh),
          corners_(corners),
          places_(flattened(mesh, corners, normal)),
          grid_(places_),
          next_(corners.size()),
          previous_(corners.size()),
          reflex_(corners.size()) {
        const auto count = static_cast<std::uint32_t>(corners.size());
        for (std::uint32_t i = 0; i < count; ++i) {
            next_[i] = i + 1 == count ? 0 : i + 1;
            previous_[i] = i == 0 ? count - 1 : i - 1;
        }
        for (std::uint32_t i = 0; i < count; ++i) {
            reflex_[i] = !isConvex(i);
            if (reflex_[i]) grid_.add(i);
        }
    }

    void cut() {
        std::uint32_t at = 0;
        std::size_t left = corners_.size(), refused = 0;
        bool tangled = false;
        while (left > 3) {
            const bool given = mesh_.cutting > mostCutting;
            // No ear left: it crosses itself or has no area, and any triangle is as good as another.
            if (!given && refused < left && !isEar(at)) {
                at = next_[at];
                ++refused;
                continue;
            }
            tangled = tangled || given || refused >= left;
            const auto before = previous_[at], after = next_[at];
            add(before, at, after);
            drop(at);
            --left;
            refused = 0;
            at = next_[after];  // not the same corner again and again, which would make needles
        }
        add(previous_[at], at, next_[at]);
        mesh_.tangled += tangled ? 1 : 0;
    }

  private:
    bool isConvex(std::uint32_t i) const {
        return turn(places_[previous_[i]], places_[i], places_[next_[i]]) > 0.0;
    }
    bool isEar(std::uint32_t i) {
        if (reflex_[i]) return false;
        const auto before = previous_[i], after = next_[i];
        const auto &a = places_[before], &b = places_[i], &c = places_[after];
        return !grid_.anyNear(a, b, c, mesh_.cutting, [&](std::uint32_t other) {
            const auto& place = places_[other];
            if (place == a || place == b || place == c) return false;
            return turn(a, b, place) >= 0.0 && turn(b, c, place) >= 0.0 && turn(c, a, place) >= 0.0;
        });
    }
    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        mesh_.triangles.push_back({corners_[a], corners_[b], corners_[c]});
    }
    void drop(std::uint32_t i) {
        if (reflex_[i]) grid_.remove(i);
        next_[previous_[i]] = next_[i];
        previous_[next_[i]] = previous_[i];
        for (const auto side : {previous_[i], next_[i]}) {
            if (!reflex_[side] || !isConvex(side)) continue;
            reflex_[side] = false;
            grid_.remove(side);
        }
    }

    ExactMesh& mesh_;
    std::span<const std::uint32_t> corners_;
    std::vector<glm::dvec2> places_;
    ReflexGrid grid_;
    std::vector<std::uint32_t> next_, previous_;
    std::vector<bool> reflex_;
};

/// Adds the triangles. `normal` is the polygon's; if it is 0, it has no area.
void cutLargePolygon(ExactMesh& mesh, std::span<const std::uint32_t> corners, const glm::dvec3& normal) {
    LargePolygon(mesh, corners, normal).cut();
}

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

void orderInSpace(TriangleMesh& mesh) {
    glm::dvec3 low(std::numeric_limits<double>::infinity());
    glm::dvec3 high = -low;
    for (const auto& position : mesh.positions) {
        low = glm::min(low, glm::dvec3(position));
        high = glm::max(high, glm::dvec3(position));
    }
    const double side = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    const double scale = side > 0.0 ? cellsAcross / side : 0.0;
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed;
    keyed.reserve(mesh.triangles.size());
    for (const auto& triangle : mesh.triangles) {
        const glm::uvec3 cell(scale * (middle(mesh, triangle) - low));
        keyed.emplace_back(mortonKey(cell.x, cell.y, cell.z), static_cast<std::uint32_t>(keyed.size()));
    }
    std::sort(keyed.begin(), keyed.end());
    mesh.triangles = inOrder(mesh.triangles, keyed);
    if (!mesh.parts.empty()) mesh.parts = inOrder(mesh.parts, keyed);
}

TriangleMesh weldMesh(TriangleMesh mesh, MeshCounts& counts) {
    counts.vertices += mesh.positions.size();
    counts.triangles += mesh.triangles.size();
    counts.smallFaces += mesh.smallFaces;
    counts.tangled += mesh.tangled;
    const auto first = firstAtPlace(mesh.positions);
    std::uint64_t placed = 0;
    for (std::uint32_t i = 0; i < first.size(); ++i) placed += first[i] == i || first[i] == noVertex ? 1 : 0;
    counts.duplicates += mesh.positions.size() - placed;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        auto& triangle = mesh.triangles[i];
        for (auto& corner : triangle) corner = first[corner];
        if (std::find(triangle.begin(), triangle.end(), noVertex) != triangle.end()) {
            ++counts.notFinite;
            continue;
        }
        const double height = heightOf(mesh, triangle);
        if (height < leastHeight) {
            ++counts.degenerate;
            continue;
        }
        if (height < needleHeight) ++counts.needles;
        keep(mesh, i, kept++);
    }
    keepFirst(mesh, kept);
    removeRepeated(mesh, counts);
    removeUnused(mesh);
    counts.unused += placed - mesh.positions.size();
    return mesh;
}

glm::dvec3 originFor(const glm::dvec3& low, const glm::dvec3& high) {
    double longest = 0.0, furthest = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        longest = std::max(longest, high[axis] - low[axis]);
        furthest = std::max({furthest, std::abs(low[axis]), std::abs(high[axis])});
    }
    glm::dvec3 origin(0.0);
    if (!(longest > 0.0) || !(furthest * floatStep > greatestStep * longest)) return origin;
    const double grain = std::pow(10.0, std::floor(std::log10(longest)));
    for (int axis = 0; axis < 3; ++axis) {
        const double middle = low[axis] + (high[axis] - low[axis]) / 2.0;
        if (std::abs(middle) > longest) origin[axis] = std::round(middle / grain) * grain;
    }
    return origin;
}

TriangleMesh toFloats(ExactMesh mesh) {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
    for (const auto& triangle : mesh.triangles) {
        for (const auto corner : triangle) {
            const auto& place = mesh.positions[corner];
            if (!isNear(place)) continue;
            low = glm::min(low, place);
            high = glm::max(high, place);
        }
    }
    TriangleMesh made;
    if (low.x <= high.x) made.origin = originFor(low, high);
    made.positions.reserve(mesh.positions.size());
    for (const auto& place : mesh.positions) made.positions.emplace_back(place - made.origin);
    made.triangles = std::move(mesh.triangles);
    made.parts = std::move(mesh.parts);
    made.smallFaces = mesh.smallFaces;
    made.tangled = mesh.tangled;
    made.notes = std::move(mesh.notes);
    return made;
}

std::string describeOrigin(const glm::dvec3& origin) {
    if (origin == glm::dvec3(0.0)) return "";
    return fmt::format(
        "({:.15g}, {:.15g}, {:.15g}) was taken off all places, which lie too far from 0 for floats: add it "
        "to have "
        "the file's own",
        origin.x, origin.y, origin.z);
}

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
