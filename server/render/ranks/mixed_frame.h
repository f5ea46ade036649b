// SPDX-License-Identifier: GPL-3.0-or-later
//
// MixedFrame: one picture in which depth matters, drawn by all ranks in batches of tiles: gather the points
// of the others' tiles, hand them over, composite one's own. One a picture and rank; the thread that draws.
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "server/render/ranks/agreement.h"
#include "server/render/ranks/frame_order.h"
#include "server/render/ranks/rank_parts.h"
#include "server/render/ranks/ranks.h"
#include "server/render/ranks/tile_distribution.h"

namespace mote::render {

class MixedFrame {
  public:
    MixedFrame(Ranks& ranks, RankParts& parts, const FrameOrder& order, Agreement& agreement,
               const std::stop_token& stop);

    /// As drawTogether().
    std::optional<Picture> draw();

  private:
    struct Batch {
        std::uint32_t begin, end;  ///< tiles
    };
    void sort();
    bool drawBatch(Batch batch);
    std::vector<Bytes> gather(Batch batch);
    void composite(Batch batch, const std::vector<Bytes>& incoming);
    void compositeTile(std::uint32_t tile, const std::vector<std::span<const std::byte>>& packed);
    /// Brings the pixels of all tiles to rank 0.
    void collect();
    template <class Visit>
    void forRows(std::uint32_t rank, Visit visit);

    Ranks& ranks_;
    RankParts& parts_;
    const FrameOrder& order_;
    const FramePlan& plan_;
    Agreement& agreement_;
    const std::stop_token& stop_;
    const TileDistribution tiles_;
    const std::uint32_t rank_;
    std::optional<CompositeFrame> frame_;
    Picture picture_;
};

}  // namespace mote::render
