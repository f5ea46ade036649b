// SPDX-License-Identifier: GPL-3.0-or-later
//
// PreviewBlocks: points whose places are told in the whole box, block by block, as the kernels want them: of
// a layer's preview, or streamed from its leaves. Shares what the plan, its step or the stream hold; read by
// any number of threads.
#pragma once

#include <cstddef>
#include <span>

#include "server/render/cpu/points_kernel.h"
#include "server/render/plan/frame_plan.h"

namespace mote::render {

class PreviewBlocks {
  public:
    static constexpr std::size_t blockPoints = storage::Preview::blockPoints;

    /// No blocks where the layer has no preview. Throws storage::StorageError.
    explicit PreviewBlocks(const PointsPlan& layer);
    /// All of `points`.
    explicit PreviewBlocks(std::span<const storage::PreviewPoint> points) : points_(points) {}

    std::size_t points() const { return points_.size(); }
    std::size_t count() const { return (points_.size() + blockPoints - 1) / blockPoints; }
    PreviewRun block(std::size_t index) const;

  private:
    const PreviewSelection* selection_ = nullptr;  // null: all
    std::span<const storage::PreviewPoint> points_;
    std::span<const float> threshold_;
};

}  // namespace mote::render
