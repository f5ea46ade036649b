// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/cpu/preview_blocks.h"

#include <algorithm>

namespace mote::render {

PreviewBlocks::PreviewBlocks(const LayerPlan& layer) : selection_(layer.preview.get()) {
    if (selection_ != nullptr) preview_ = layer.step->preview(selection_->points);
}

PreviewRun PreviewBlocks::block(std::size_t index) const {
    const std::size_t begin = index * blockPoints;
    return {.points = preview_.points.data() + begin,
            .count = std::min(blockPoints, preview_.points.size() - begin),
            .limit = selection_->limit.data(),
            .threshold = preview_.threshold[index]};
}

}  // namespace mote::render
