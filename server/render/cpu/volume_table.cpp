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

VolumeTable::VolumeTable(const ParticlesStyle& style) : table_(style) {
    integrals_.push_back({0.0F, 0.0F});  // where x = 1 was rounded down
    colors_.push_back(packedRoot(style.colorMap(0.0)));
    double integral = 0.0;
    for (std::uint32_t i = 0; i <= cells; ++i) {
        const float slope = i < cells ? table_.extinctions()[i] : 0.0F;
        integrals_.push_back({static_cast<float>(integral), slope});
        integral += slope;
        const double t = -LogDensity::fade + (1.0 + LogDensity::fade) * (i + 0.5) / cells;
        colors_.push_back(packedRoot(style.colorMap(std::clamp(t, 0.0, 1.0))));
    }
}

}  // namespace mote::render
