// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/volume_table.h"

#include <algorithm>
#include <cmath>

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
    const double width = (high - low) / cells;
    const auto& within = table_.extinctions();
    const auto below = static_cast<float>(extinction(low)), above = static_cast<float>(extinction(high));
    entries_.push_back({-below, below, packedRoot(color(low)), 0.0F});
    double integral = 0.0;
    for (std::uint32_t i = 0; i < cells; ++i) {
        const float bend = 0.5F * within[i].change;
        entries_.push_back({static_cast<float>(integral), within[i].mean - bend,
                            packedRoot(color(low + (i + 0.5) * width)), bend});
        integral += within[i].mean;
    }
    entries_.push_back({static_cast<float>(integral), above, packedRoot(color(high)), 0.0F});
}

}  // namespace mote::render
