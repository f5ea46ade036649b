// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/preview_blocks.h"

#include <algorithm>

namespace mote::render {

PreviewBlocks::PreviewBlocks(const PointsPlan& layer) : selection_(layer.preview.get()) {
    if (selection_ == nullptr) return;
    const storage::Preview preview = layer.step->preview(selection_->points);
    points_ = preview.points;
    threshold_ = preview.threshold;
}

PreviewRun PreviewBlocks::block(std::size_t index) const {
    static constexpr PreviewSelection all{.points = 0, .limit = {}};
    const std::size_t begin = index * blockPoints;
    return {.points = points_.data() + begin,
            .count = std::min(blockPoints, points_.size() - begin),
            .limit = selection_ != nullptr ? selection_->limit.data() : all.limit.data(),
            .threshold = selection_ != nullptr ? threshold_[index] : 0.0F};
}

}  // namespace mote::render
