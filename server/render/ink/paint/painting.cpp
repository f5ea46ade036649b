// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/paint/painting.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <unordered_map>

#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

/// Tells whether a place lies within the radius of a dab: in a grid of cells as large as that, so that few
/// dabs are asked.
class Dabs {
  public:
    explicit Dabs(const PaintedRegion& region) : radius_(region.radius), low_(HUGE_VAL), high_(-HUGE_VAL) {
        for (const auto& dab : region.dabs) {
            low_ = glm::min(low_, dab - radius_);
            high_ = glm::max(high_, dab + radius_);
        }
        for (const auto& dab : region.dabs) cells_[keyOf(cellOf(dab))].push_back(dab);
    }

    bool has(const glm::dvec3& place) const {
        for (int axis = 0; axis < 3; ++axis) {
            if (!(place[axis] >= low_[axis] && place[axis] <= high_[axis])) return false;
        }
        const glm::dvec3 cell = cellOf(place);
        for (int i = 0; i < 27; ++i) {
            const glm::dvec3 off(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
            const auto found = cells_.find(keyOf(cell + off));
            if (found == cells_.end()) continue;
            for (const auto& dab : found->second) {
                if (glm::distance(place, dab) <= radius_) return true;
            }
        }
        return false;
    }

  private:
    /// From the least corner on; of what lies very far from it for so small a radius the last.
    glm::dvec3 cellOf(const glm::dvec3& place) const {
        return glm::floor(glm::clamp((place - low_) / radius_, 0.0, 1e6));
    }
    static std::uint64_t keyOf(const glm::dvec3& cell) {
        const auto at = [](double along) { return static_cast<std::uint64_t>(along + 1.0); };
        return (at(cell.z) << 42U) | (at(cell.y) << 21U) | at(cell.x);  // below 2^21 each
    }

    double radius_;
    glm::dvec3 low_, high_;
    std::unordered_map<std::uint64_t, std::vector<glm::dvec3>> cells_;
};

/// The pixels that see a region's dabs.
Raster<std::uint8_t> seenOf(const PaintedRegion& region, const Modalities& modalities,
                            const InkCamera& camera, const std::stop_token& stop) {
    const auto& depth = modalities.depth;
    const Dabs dabs(region);
    const glm::dmat4 fromEye = glm::inverse(camera.toEye);
    Raster<std::uint8_t> seen(depth.width, depth.height);
    forInTurns(std::uint32_t{0}, depth.height, [&](std::uint32_t row) {
        if (isStopped(stop)) return;
        for (std::uint32_t column = 0; column < depth.width; ++column) {
            const auto own = static_cast<double>(depth.at(column, row));
            if (!std::isfinite(own)) continue;
            const glm::dvec3 inEye = camera.inEye({{column + 0.5, row + 0.5}, own});
            seen.at(column, row) = dabs.has(glm::dvec3(fromEye * glm::dvec4(inEye, 1.0))) ? 1 : 0;
        }
    });
    return seen;
}

/// Adds to pixels that are seen all that are in one segment with any of them.
void makeWhole(Raster<std::uint8_t>& seen, const Segments& segments) {
    std::vector<std::uint8_t> touched(segments.count);
    const auto& label = segments.label.values;
    for (std::size_t i = 0; i < label.size(); ++i) {
        if (seen.values[i] != 0 && label[i] < segments.count) touched[label[i]] = 1;
    }
    for (std::size_t i = 0; i < label.size(); ++i) {
        if (label[i] < segments.count && touched[label[i]] != 0) seen.values[i] = 1;
    }
}

/// A direction on the screen, whose y axis goes down, radians.
std::optional<double> onScreen(const std::optional<double>& degrees) {
    if (!degrees) return std::nullopt;
    return -*degrees * std::numbers::pi / 180.0;
}

}  // namespace

Painting::Painting(const Modalities& modalities, const InkCamera& camera,
                   const std::vector<PaintedRegion>& regions, Segments& segments,
                   const std::stop_token& stop) {
    if (regions.empty()) return;
    region_ = Raster<std::uint8_t>(modalities.depth.width, modalities.depth.height);
    for (const auto& region : regions) {
        if (isStopped(stop)) return;
        fills_.push_back(region.fill);
        auto seen = seenOf(region, modalities, camera, stop);
        if (region.whole) makeWhole(seen, segments);
        for (std::size_t i = 0; i < seen.values.size(); ++i) {
            if (seen.values[i] == 0) continue;
            region_.values[i] = static_cast<std::uint8_t>(fills_.size());
            if (!segments.label.values.empty()) segments.label.values[i] = segments.count;
        }
        if (segments.label.values.empty()) continue;
        segments.directions.resize(segments.count);
        segments.directions.push_back(onScreen(region.direction));
        ++segments.count;
    }
}

bool Painting::has(RegionFill fill) const {
    return std::find(fills_.begin(), fills_.end(), fill) != fills_.end();
}

}  // namespace mote::render
