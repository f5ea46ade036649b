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
#include <optional>
#include <vector>

#include "protocol/base/most_recent.h"
#include "server/render/plan/field_blocks.h"
#include "server/render/plan/field_plan.h"
#include "server/render/plan/transfer_table.h"

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

/// What is known of a field; nothing is owned.
struct SeenField {
    const TransferTable* table = nullptr;
    const VisibleBlocks* blocks = nullptr;  ///< null: nothing of it is seen
    const BlockRanges* ranges = nullptr;    ///< of the same blocks; null with them
    const GridSlopes* slopes = nullptr;     ///< where its extinction goes by them; null with the blocks
};

class SeenFields {
  public:
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
        std::optional<GridSlopes> slopes;  ///< once they are asked for
        std::list<Visible> visible;        ///< used last first
    };
    static constexpr std::size_t kept = 16;  ///< curves of a field: more than a picture has layers

    Resident& resident(const std::shared_ptr<const void>& data, bool corrected, bool mixed,
                       const std::function<BlockRanges()>& ranges);

    TransferTables<TransferTable> tables_;
    std::list<Resident> fields_;
};

}  // namespace mote::render
