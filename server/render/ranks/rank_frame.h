// SPDX-License-Identifier: GPL-3.0-or-later
//
// One picture, drawn by all ranks: each adds up the points of its own leaves; if depth matters, it sends
// their cells to the owners of the tiles, who composite them with the volumes, which every rank has. Sums do
// not depend on which rank's points lie in front: no order of the ranks is needed. All ranks call it alike.
// It may give way between batches of tiles, and then keeps what it sorted.
//
// What throws between two messages would leave the other ranks waiting: whatever takes much memory is done in
// an attempt, before all agree to go on; if there is none for the few words that are left, all end
// (ranks.h).
#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "server/render/cpu/cpu_parts.h"
#include "server/render/ranks/agreement.h"
#include "server/render/ranks/distribution.h"
#include "server/render/ranks/frame_order.h"
#include "server/render/ranks/ranks.h"

namespace mote::render {

/// A rank's part of a picture. It stays where it is made.
class SharedPicture {
  public:
    /// `order`: with the rank's own steps. What it draws with belongs to `parts`, but for its sorted lists.
    SharedPicture(Ranks& ranks, CpuParts& parts, FrameOrder order);
    SharedPicture(const SharedPicture&) = delete;
    SharedPicture& operator=(const SharedPicture&) = delete;

    /// What fails before begin() may fail in it.
    Agreement& agreement() { return agreement_; }
    FrameOrder& order() { return order_; }
    std::uint64_t number() const { return order_.number; }

    /// Sorts what is drawn; draws it if depth does not matter. Whether the ranks go on: not if one of
    /// them failed, or `stop` was requested on rank 0 before that was done.
    bool begin(const std::stop_token& stop);
    /// Whether all is drawn: if begin() did it.
    bool drawn() const { return next_ == tiles_.tiles; }
    /// Draws batches of tiles until all are drawn or `pause` is requested on rank 0, but one in any case.
    /// Whether it came to an end: then it is drawn, or one of the ranks failed. The steps are checked.
    bool advance(const std::stop_token& pause);
    /// The picture that is drawn, on rank 0. The lists go back to the parts.
    Picture take();
    void giveBack();
    /// In memory, about, apart from its plan.
    std::uint64_t bytes() const;

  private:
    struct Batch {
        std::uint32_t begin, end;  ///< tiles
    };
    void sort(const std::stop_token& stop);
    void goOn();
    bool drawBatch();
    std::vector<Bytes> gather(Batch batch);
    void composite(Batch batch, const std::vector<Bytes>& incoming);
    void compositeTile(std::uint32_t tile, const std::vector<std::span<const std::byte>>& packed);
    std::vector<Bytes> ownRows();
    /// Brings the pixels of all tiles, each rank's ownRows(), to rank 0.
    void collect(const std::vector<Bytes>& outgoing) noexcept;
    template <class Visit>
    void forRows(std::uint32_t rank, Visit visit);

    Ranks& ranks_;
    CpuParts& parts_;
    FrameOrder order_;
    const FramePlan& plan_;
    const TileDistribution tiles_;
    const std::uint32_t rank_;
    Agreement agreement_;
    FramePoints points_;
    FrameDots dots_;
    std::optional<CompositeFrame> frame_;
    Picture picture_;
    std::uint32_t next_ = 0;  // tile
    bool waited_ = false;     // since the points were verified
};

}  // namespace mote::render
