// SPDX-License-Identifier: GPL-3.0-or-later
//
// PreviewBlocks: the points of a layer's preview, block by block, as the kernels want them. Shares what the
// plan and its step hold; read by any number of threads.
#pragma once

#include <cstddef>

#include "server/render/cpu/points_kernel.h"
#include "server/render/frame_plan.h"

namespace mote::render {

class PreviewBlocks {
  public:
    static constexpr std::size_t blockPoints = storage::Preview::blockPoints;

    /// No blocks where the layer has no preview. Throws storage::StorageError.
    explicit PreviewBlocks(const LayerPlan& layer);

    std::size_t count() const { return (preview_.points.size() + blockPoints - 1) / blockPoints; }
    PreviewRun block(std::size_t index) const;

  private:
    const PreviewSelection* selection_;
    storage::Preview preview_;
};

}  // namespace mote::render
