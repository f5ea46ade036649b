// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/volume_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "protocol/scene/log_density.h"

namespace mote::render {
namespace {

std::uint32_t packedRoot(const glm::dvec3& linear) {
    const auto root = [](double component) {
        return static_cast<std::uint32_t>(std::lround(1023.0 * std::sqrt(std::clamp(component, 0.0, 1.0))));
    };
    return root(linear.x) | root(linear.y) << 10 | root(linear.z) << 20;
}

}  // namespace

VolumeTable::VolumeTable(const ParticlesStyle& style)
    : VolumeTable(
          -LogDensity::fade, 1.0, [&](double t) { return style.extinction(t); },
          [&](double t) { return style.colorMap(t); }) {}

VolumeTable::VolumeTable(double low, double high, const std::function<double(double)>& extinction,
                         const std::function<glm::dvec3(double)>& color)
    : table_(low, high, extinction, color) {
    const auto& ofCells = table_.ofCells();
    const auto below = static_cast<float>(extinction(low)), above = static_cast<float>(extinction(high));
    entries_.push_back({-below, below, packedRoot(ofCells.front().color), 0.0F});
    double integral = 0.0;
    for (const auto& cell : ofCells) {
        const double bend = 0.5 * cell.change;
        entries_.push_back({static_cast<float>(integral), static_cast<float>(cell.extinction - bend),
                            packedRoot(cell.color), static_cast<float>(bend)});
        integral += cell.extinction;
    }
    entries_.push_back({static_cast<float>(integral), above, packedRoot(ofCells.back().color), 0.0F});
    nextVisible_.assign(entries_.size(), std::numeric_limits<float>::infinity());
    for (std::size_t i = entries_.size(); i-- > 0;) {
        if (entries_[i].mean() > 0.0F) {
            nextVisible_[i] = static_cast<float>(i);
        } else if (i + 1 < entries_.size()) {
            nextVisible_[i] = nextVisible_[i + 1];
        }
    }
}

}  // namespace mote::render
