// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/transfer_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

std::uint32_t packedRoot(const glm::dvec3& linear) {
    const auto root = [](double component) {
        return static_cast<std::uint32_t>(std::lround(1023.0 * std::sqrt(std::clamp(component, 0.0, 1.0))));
    };
    return root(linear.x) | root(linear.y) << 10 | root(linear.z) << 20;
}

}  // namespace

TransferFunction colorsOf(TransferFunction transfer) {
    transfer.opacity = Curve::constant(0.5);
    transfer.fade = 0.0;
    return transfer;
}

TransferTable::TransferTable(const TransferFunction& transfer)
    : TransferTable(
          transfer.span.low, transfer.span.high, [&](double value) { return transfer.extinction(value); },
          [&](double value) { return transfer.color(value); }) {}

TransferTable::TransferTable(double low, double high, const std::function<double(double)>& extinction,
                             const std::function<glm::dvec3(double)>& color)
    : low_(low), high_(high), ofCells_(cells), visibleBefore_(cells + 1, 0) {
    const double cellWidth = (high - low) / cells;
    for (std::uint32_t i = 0; i < cells; ++i) {
        const Cell& cell = ofCells_[i] = cellOf(low + i * cellWidth, cellWidth, extinction, color);
        visibleBefore_[i + 1] = visibleBefore_[i] + (cell.extinction > 0.0 ? 1 : 0);
    }
    spreadColors();
    addEntries(extinction(low), extinction(high));
    findNextVisible();
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

void TransferTable::addEntries(double extinctionBelow, double extinctionAbove) {
    const auto below = static_cast<float>(extinctionBelow), above = static_cast<float>(extinctionAbove);
    entries_.push_back({-below, below, packedRoot(ofCells_.front().color), 0.0F});
    double integral = 0.0;
    for (const auto& cell : ofCells_) {
        const double bend = 0.5 * cell.change;
        entries_.push_back({static_cast<float>(integral), static_cast<float>(cell.extinction - bend),
                            packedRoot(cell.color), static_cast<float>(bend)});
        integral += cell.extinction;
    }
    entries_.push_back({static_cast<float>(integral), above, packedRoot(ofCells_.back().color), 0.0F});
}

void TransferTable::findNextVisible() {
    nextVisible_.assign(entries_.size(), std::numeric_limits<float>::infinity());
    for (std::size_t i = entries_.size(); i-- > 0;) {
        if (entries_[i].mean() > 0.0F) {
            nextVisible_[i] = static_cast<float>(i);
        } else if (i + 1 < entries_.size()) {
            nextVisible_[i] = nextVisible_[i + 1];
        }
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
