// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/transfer_table.h"

#include <algorithm>
#include <cmath>

#include "protocol/scene/log_density.h"

namespace mote::render {
namespace {

constexpr double cellWidth = (1.0 + LogDensity::fade) / TransferTable::cells;

}  // namespace

TransferTable::TransferTable(const ParticlesStyle& style)
    : integrals_(cells + 1), extinctions_(cells), visibleBefore_(cells + 1, 0) {
    // Extinction may jump within a cell (a step of the curve); color changes slowly.
    constexpr int parts = 8;
    glm::dvec4 integral(0.0);
    integrals_[0] = glm::vec4(0.0F);
    for (std::uint32_t i = 0; i < cells; ++i) {
        const double low = -LogDensity::fade + i * cellWidth;
        double mean = 0.0;
        for (int part = 0; part < parts; ++part)
            mean += style.extinction(low + (part + 0.5) / parts * cellWidth) / parts;
        if (mean > 0.0) integral += cellWidth * mean * glm::dvec4(style.colorMap(low + 0.5 * cellWidth), 1.0);
        extinctions_[i] = static_cast<float>(mean);
        integrals_[i + 1] = glm::vec4(integral);
        visibleBefore_[i + 1] = visibleBefore_[i] + (mean > 0.0 ? 1 : 0);
    }
}

bool TransferTable::visible(float low, float high) const {
    const auto cellOf = [](double t) {
        return std::clamp((t + LogDensity::fade) / cellWidth, 0.0, double{cells});
    };
    const auto first = static_cast<std::uint32_t>(std::max(0.0, std::floor(cellOf(low)) - 1.0));
    const auto last = static_cast<std::uint32_t>(std::min(std::ceil(cellOf(high)) + 1.0, double{cells}));
    return visibleBefore_[last] > visibleBefore_[first];
}

}  // namespace mote::render
