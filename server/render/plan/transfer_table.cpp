// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/transfer_table.h"

#include <algorithm>
#include <cmath>

#include "protocol/scene/log_density.h"

namespace mote::render {
namespace {

TransferTable::Cell cellOf(double from, double width, const std::function<double(double)>& extinction,
                           const std::function<glm::dvec3(double)>& color) {
    // A curve may jump within a cell, and its colour with it.
    constexpr int parts = 8;
    // What holds at the very end of a cell may be the next one's.
    constexpr double end = 1e-6;
    TransferTable::Cell cell;
    for (int part = 0; part < parts; ++part) {
        const double at = from + (part + 0.5) / parts * width;
        const double here = extinction(at) / parts;
        cell.extinction += here;
        if (here > 0.0) cell.color += here * color(at);
    }
    if (cell.extinction > 0.0) cell.color /= cell.extinction;
    cell.change = extinction(from + (1.0 - end) * width) - extinction(from + end * width);
    return cell;
}

}  // namespace

TransferTable::TransferTable(const ParticlesStyle& style)
    : TransferTable(
          -LogDensity::fade, 1.0, [&](double t) { return style.extinction(t); },
          [&](double t) { return style.colorMap(t); }) {}

TransferTable::TransferTable(double low, double high, const std::function<double(double)>& extinction,
                             const std::function<glm::dvec3(double)>& color)
    : low_(low), high_(high), ofCells_(cells), visibleBefore_(cells + 1, 0) {
    const double cellWidth = (high - low) / cells;
    for (std::uint32_t i = 0; i < cells; ++i) {
        const Cell& cell = ofCells_[i] = cellOf(low + i * cellWidth, cellWidth, extinction, color);
        visibleBefore_[i + 1] = visibleBefore_[i] + (cell.extinction > 0.0 ? 1 : 0);
    }
    spreadColors();
}

void TransferTable::spreadColors() {
    const auto shown = [](const Cell& cell) { return cell.extinction > 0.0; };
    auto last = ofCells_.begin();  // after the cells that are done
    glm::dvec3 before{0.0};        // of the last that is shown
    for (auto next = std::find_if(last, ofCells_.end(), shown); next != ofCells_.end();
         next = std::find_if(last, ofCells_.end(), shown)) {
        const auto middle = last == ofCells_.begin() ? last : last + (next - last) / 2;
        std::for_each(last, middle, [&](Cell& cell) { cell.color = before; });
        std::for_each(middle, next, [&](Cell& cell) { cell.color = next->color; });
        before = next->color;
        last = next + 1;
    }
    std::for_each(last, ofCells_.end(), [&](Cell& cell) { cell.color = before; });
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
