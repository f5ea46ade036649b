// SPDX-License-Identifier: GPL-3.0-or-later
//
// SeenFields keeps what does not depend on the camera of fields: their transfer tables, the ranges of their
// values by block, and where they are visible. It holds no data alive. Owned by a device, used on its
// thread; what it returns may be read by any number until the next picture.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <utility>
#include <vector>

#include "protocol/base/most_recent.h"
#include "server/render/plan/field_blocks.h"
#include "server/render/plan/field_plan.h"
#include "server/render/plan/transfer_table.h"
#include "storage/blocks/counted_cache.h"

namespace mote::render {

/// What is made of the transfer functions of the latest pictures.
template <class Made>
class TransferTables {
  public:
    /// The reference stays valid for the next 15 calls.
    const Made& of(const TransferFunction& transfer) {
        constexpr std::size_t kept = 16;  // more than a picture has layers
        return mostRecent(
                   entries_, kept, [&](const Entry& one) { return one.transfer == transfer; },
                   [&] {
                       return Entry{transfer, Made(transfer)};
                   })
            .made;
    }

  private:
    struct Entry {
        TransferFunction transfer;
        Made made;
    };
    std::list<Entry> entries_;  // used last first
};

/// The range of values in blocks of 8 cells of the grid that rays go by: the bricks' where they are drawn,
/// the coarse one otherwise. Corrected bricks are fine. Works in parallel.
BlockRanges gridRanges(const CorrectedField& field);

/// How steeply a field changes at its samples, in 255ths (docs/PICTURE.md, "Gradients"), in their order; four
/// more than these can be read.
struct GridSlopes {
    std::vector<std::uint8_t> coarse, bricks;
};
/// `corrected`: whether the bricks are drawn, where there are some. Works in parallel.
GridSlopes gridSlopes(const GridField& field, bool corrected);
/// That they take in memory.
std::uint64_t gridSlopesBytes(const GridField& field, bool corrected);

/// What is known of a field; nothing is owned but its slopes.
struct SeenField {
    const TransferTable* table = nullptr;
    const VisibleBlocks* blocks = nullptr;  ///< null: nothing of it is seen
    const BlockRanges* ranges = nullptr;    ///< of the same blocks; null with them
    /// Where its extinction goes by them; null with the blocks.
    std::shared_ptr<const GridSlopes> slopes = nullptr;
};

class SeenFields {
  public:
    /// Slopes count to `budget` from now on, and may go for others; null, as at first: to none.
    void countTo(std::shared_ptr<storage::BlockBudget> budget) { slopes_.countTo(std::move(budget)); }
    /// `samples`: the plan's. Works in parallel.
    SeenField of(const FieldPlan& plan, const CorrectedField& samples);
    /// `ranges` tells those of the field's extinction, where they are not known.
    SeenField of(const FieldPlan& plan, const DensityField& samples,
                 const std::function<BlockRanges()>& ranges);
    /// Gives up what belongs to data that nobody else holds any more.
    void dropExpired();

  private:
    struct Visible {
        Curve opacity;
        VisibleBlocks blocks;
    };
    struct Resident {
        std::weak_ptr<const void> data;
        const void* key;
        bool corrected, mixed;
        BlockRanges ranges;
        std::list<Visible> visible;  ///< used last first
    };
    static constexpr std::size_t kept = 16;  ///< curves of a field: more than a picture has layers

    Resident& resident(const std::shared_ptr<const void>& data, bool corrected, bool mixed,
                       const std::function<BlockRanges()>& ranges);
    std::shared_ptr<const GridSlopes> slopesOf(const CorrectedField& samples);

    TransferTables<TransferTable> tables_;
    std::list<Resident> fields_;
    storage::CountedCache<bool, GridSlopes> slopes_;  ///< by whether they are the bricks', too
};

}  // namespace mote::render
