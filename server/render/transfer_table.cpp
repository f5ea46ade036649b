// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/transfer_table.h"

#include <algorithm>
#include <cmath>

#include "protocol/scene/log_density.h"

namespace mote::render {
TransferTable::TransferTable(const ParticlesStyle& style)
    : TransferTable(
          -LogDensity::fade, 1.0, [&](double t) { return style.extinction(t); },
          [&](double t) { return style.colorMap(t); }) {}

TransferTable::TransferTable(double low, double high, const std::function<double(double)>& extinction,
                             const std::function<glm::dvec3(double)>& color)
    : low_(low), high_(high), integrals_(cells + 1), extinctions_(cells), visibleBefore_(cells + 1, 0) {
    const double cellWidth = (high - low) / cells;
    // Extinction may jump within a cell (a step of the curve); color changes slowly.
    constexpr int parts = 8;
    // What holds at the very end of a cell may be the next one's.
    constexpr double end = 1e-6;
    glm::dvec4 integral(0.0);
    integrals_[0] = glm::vec4(0.0F);
    for (std::uint32_t i = 0; i < cells; ++i) {
        const double from = low + i * cellWidth;
        double mean = 0.0;
        for (int part = 0; part < parts; ++part)
            mean += extinction(from + (part + 0.5) / parts * cellWidth) / parts;
        if (mean > 0.0) integral += cellWidth * mean * glm::dvec4(color(from + 0.5 * cellWidth), 1.0);
        const double change = extinction(from + (1.0 - end) * cellWidth) - extinction(from + end * cellWidth);
        extinctions_[i] = {static_cast<float>(mean), static_cast<float>(change)};
        integrals_[i + 1] = glm::vec4(integral);
        visibleBefore_[i + 1] = visibleBefore_[i] + (mean > 0.0 ? 1 : 0);
    }
}

bool TransferTable::visible(double low, double high) const {
    const auto cellOf = [this](double t) {
        return std::clamp((t - low_) / (high_ - low_) * cells, 0.0, double{cells});
    };
    // Beyond an end it is as in the last cell there.
    const double first = std::clamp(std::floor(cellOf(low)) - 1.0, 0.0, cells - 1.0);
    const double last = std::clamp(std::ceil(cellOf(high)) + 1.0, 1.0, double{cells});
    return visibleBefore_[static_cast<std::size_t>(last)] > visibleBefore_[static_cast<std::size_t>(first)];
}

}  // namespace mote::render
