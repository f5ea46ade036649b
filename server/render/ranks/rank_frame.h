// SPDX-License-Identifier: GPL-3.0-or-later
//
// One picture, drawn by all ranks: each adds up the points of its own leaves; where depth matters, it sends
// their cells to the owners of the tiles, who composite them with the volumes, which every rank has. Sums do
// not depend on which rank's points lie in front: no order of the ranks is needed. All ranks call it alike.
// It may give way between batches of tiles, and then keeps what it sorted.
#pragma once

#include <exception>
#include <new>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "protocol/scene/error.h"
#include "server/render/cpu/cpu_parts.h"
#include "server/render/ranks/distribution.h"
#include "server/render/ranks/frame_order.h"
#include "server/render/ranks/ranks.h"
#include "storage/storage_error.h"

namespace mote::render {

/// Agreement: how a picture goes on or ends on all ranks alike, though one of them fails or the picture is
/// stopped. One a picture and rank; one thread.
class Agreement {
  public:
    explicit Agreement(Ranks& ranks) : ranks_(ranks) {}

    /// Does this rank's work, unless some of it failed before. What is thrown waits for all().
    template <class Work>
    void attempt(Work work) {
        if (error_) return;
        try {
            work();
        } catch (const storage::StorageError& failure) {
            error_ = failure.error();
        } catch (const std::bad_alloc&) {
            error_ = Error{ErrorCode::resourceExhausted, "view", "there is not enough memory to draw it"};
        } catch (const std::exception& failure) {
            error_ = Error{ErrorCode::internal, "view", failure.what()};
        }
    }

    /// All ranks call it: whether they go on. Not where one of them failed, or `stop` was requested on one.
    bool all(const std::stop_token& stop);
    /// What all() said latest.
    bool wentOn() const { return wentOn_; }
    /// All ranks call it: whether `pause` was requested on one.
    bool paused(const std::stop_token& pause);

    /// The first failure, naming its rank, on rank 0 once all() said no; nothing where it was a stop.
    const std::optional<Error>& failure() const { return error_; }

  private:
    void collectErrors();

    Ranks& ranks_;
    std::optional<Error> error_;
    bool wentOn_ = true;
};

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

    /// Sorts what is drawn; draws it where depth does not matter. Whether the ranks go on: not where one of
    /// them failed, or `stop` was requested on rank 0 before that was done.
    bool begin(const std::stop_token& stop);
    /// Whether all is drawn: where begin() did it.
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
    /// Brings the pixels of all tiles to rank 0.
    void collect();
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
