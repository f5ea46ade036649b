// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/mesh/large_polygon.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <limits>

namespace mote::prep {
namespace {

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

}  // namespace

void cutLargePolygon(ExactMesh& mesh, std::span<const std::uint32_t> corners, const glm::dvec3& normal) {
    LargePolygon(mesh, corners, normal).cut();
}

}  // namespace mote::prep
