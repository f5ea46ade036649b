// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/numbers/nearest_point.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <vector>

#include "protocol/scene/drawn_points.h"
#include "server/render/plan/point_selection.h"
#include "storage/numbers/point_places.h"
#include "storage/particles/octree_cell.h"

namespace mote::server {
namespace {

constexpr std::uint64_t askedEach = 4096;  // cells

class Search {
  public:
    Search(const storage::ParticleStep& step, const Curve& fraction, const View& view,
           const glm::dmat4& layerToWorld, const HalfSpaces& clips, const PicturePlace& place,
           NearestPoint& best)
        : walk_(step),
          map_(view.camera, view.aspect(), layerToWorld),
          fraction_(fraction),
          width_(view.width),
          height_(view.height),
          clips_(clips),
          place_(place),
          best_(best) {}

    bool run(const std::function<bool()>& cancelled) {
        const auto& nodes = walk_.nodes();
        if (nodes.size() == 0 || walk_.step().pointCount() == 0) return true;
        const double end = render::zeroFrom(fraction_);
        open_.push({0.0, 0});
        for (std::uint64_t visited = 0; !open_.empty(); ++visited) {
            if (visited % askedEach == 0 && cancelled && cancelled()) return false;
            const auto [distance, node] = open_.top();
            open_.pop();
            if (distance > best_.distance) return true;  // and so are all others
            if (nodes.count[node] == 0 || walk_.step().logDensity().ofLeaf(nodes.minDensity[node]) > end)
                continue;
            if (nodes.childCount[node] == 0) {
                look(nodes.firstChild[node]);
                continue;
            }
            for (std::uint32_t child = 0; child < nodes.childCount[node]; ++child) {
                const std::uint32_t next = nodes.firstChild[node] + child;
                const double nearest = distanceTo(next);
                if (nearest <= best_.distance) open_.push({nearest, next});
            }
        }
        return true;
    }

  private:
    struct Open {
        double distance;  ///< of anything in it, at least; pixels
        std::uint32_t node;
        bool operator<(const Open& other) const { return distance > other.distance; }
    };

    /// Pixels from the place to the smallest rectangle around a cell on the screen; infinite if no point
    /// of it is seen, 0 if that cannot be told.
    double distanceTo(std::uint32_t node) const {
        const auto& nodes = walk_.nodes();
        const double edge = std::ldexp(2.0, -nodes.level[node]);
        const auto low = glm::dvec3(-1.0) + edge * glm::dvec3(storage::cellPlace(nodes.morton[node]));
        double lowX = INFINITY, lowY = INFINITY, highX = -INFINITY, highY = -INFINITY;
        int unseen = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const auto seen = map_(low + edge * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1));
            if (std::isnan(seen.x)) {
                ++unseen;
                continue;
            }
            lowX = std::min(lowX, seen.x * width_);
            highX = std::max(highX, seen.x * width_);
            lowY = std::min(lowY, seen.y * height_);
            highY = std::max(highY, seen.y * height_);
        }
        if (unseen == 8) return INFINITY;
        if (unseen > 0) return 0.0;
        // Rounding must not lose a point that lies on its cell's side.
        const double little =
            1e-9 * (1.0 + std::max({std::abs(lowX), std::abs(highX), std::abs(lowY), std::abs(highY)}));
        const double across = std::max({lowX - place_.x, place_.x - highX, 0.0});
        const double down = std::max({lowY - place_.y, place_.y - highY, 0.0});
        return std::max(0.0, std::hypot(across, down) - little);
    }

    void look(std::size_t leaf) {
        const auto& leaves = walk_.leaves();
        const auto& nodes = walk_.nodes();
        const auto cell = walk_.cell(leaf);
        const auto node = leaves.node[leaf];
        const double density = walk_.step().logDensity().ofLeaf(leaves.density[leaf]);
        const auto drawn =
            drawnPoints(fraction_(density), leaves.pointCount[leaf], nodes.level[node], nodes.morton[node]);
        if (drawn == 0) return;
        const auto positions = walk_.step().positions(leaves.pointBegin[leaf], drawn);
        for (std::size_t i = 0; i < positions.size(); ++i) {
            NearestPoint found;
            found.position = cell.at(positions[i]);
            const auto seen = map_(found.position);
            if (std::isnan(seen.x) || !inAll(clips_, found.position)) continue;
            found.distance = std::hypot(seen.x * width_ - place_.x, seen.y * height_ - place_.y);
            found.depth = seen.depth;
            found.point = leaves.pointBegin[leaf] + i;
            found.density = density;
            if (found.before(best_)) best_ = found;
        }
    }

    const storage::LeafWalk walk_;
    const storage::PictureMap map_;
    const Curve& fraction_;
    const double width_, height_;
    const HalfSpaces& clips_;
    const PicturePlace place_;
    NearestPoint& best_;
    std::priority_queue<Open> open_;  // the nearest on top
};

}  // namespace

bool findNearest(const storage::ParticleStep& step, const Curve& fraction, const View& view,
                 const glm::dmat4& layerToWorld, const HalfSpaces& clips, const PicturePlace& place,
                 const std::function<bool()>& cancelled, NearestPoint& best) {
    return Search(step, fraction, view, layerToWorld, clips, place, best).run(cancelled);
}

}  // namespace mote::server
