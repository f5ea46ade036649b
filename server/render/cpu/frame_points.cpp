// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/frame_points.h"

#include <algorithm>

namespace mote::render {

bool FramePoints::sort(const FramePlan& plan, ResidentLeaves& leaves, const std::stop_token& stop) {
    layers_.resize(plan.points.size());
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        const PointsPlan& layer = plan.points[i];
        const auto cells = leaves.of(layer.step).upTo(*layer.step, layer.selection->drawn.size());
        if (!layers_[i].sort(plan, layer, cells, stop)) return false;
    }
    return true;
}

bool FramePoints::any(Tile tile) const {
    return std::any_of(layers_.begin(), layers_.end(), [&](const auto& layer) { return layer.any(tile); });
}

std::span<TileCells> FramePoints::gather(Tile tile) {
    auto& cells = cells_.local();
    cells.resize(layers_.size(), TileCells(0));
    for (std::size_t i = 0; i < layers_.size(); ++i) {
        const std::uint32_t slabs = layers_[i].slabs(), first = layers_[i].firstSlab();
        if (cells[i].slabs() == slabs && cells[i].firstSlab() == first) {
            cells[i].clear();
        } else {
            cells[i] = TileCells(slabs, first);
        }
        layers_[i].gather(tile, cells[i]);
    }
    return cells;
}

void FramePoints::appendAlone(Tile tile, std::vector<ScreenDot>& out) const {
    for (const auto& layer : layers_) layer.appendAlone(tile, out);
}

std::uint64_t FramePoints::pointsDrawn(bool alone) const {
    std::uint64_t points = 0;
    for (const auto& layer : layers_) points += layer.alone() && !alone ? 0 : layer.pointsDrawn();
    return points;
}

}  // namespace mote::render
