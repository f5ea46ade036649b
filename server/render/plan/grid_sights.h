// SPDX-License-Identifier: GPL-3.0-or-later
//
// GridSights keeps what does not depend on the camera of fields of samples: their transfer tables, the ranges
// of their values by block, and where they are visible. It holds no field alive. Owned by a device, used on
// its thread; what it returns may be read by any number until the next picture.
#pragma once

#include <list>
#include <memory>

#include "server/render/plan/field_blocks.h"
#include "server/render/plan/field_plan.h"
#include "server/render/plan/transfer_table.h"

namespace mote::render {

/// The transfer tables of the latest pictures.
class TransferTables {
  public:
    /// The reference stays valid for the next 15 calls.
    const TransferTable& of(const TransferFunction& transfer);

  private:
    struct Entry {
        TransferFunction transfer;
        TransferTable table;
    };
    std::list<Entry> entries_;  // used last first
};

/// The range of values in blocks of 8 cells of the grid that rays go by: the bricks' where they are drawn,
/// the coarse one otherwise. Corrected bricks are fine. Works in parallel.
BlockRanges gridRanges(const CorrectedField& field);

/// What is known of a field that is somewhere visible; nothing is owned.
struct GridSight {
    const TransferTable* table = nullptr;
    const VisibleBlocks* blocks = nullptr;  ///< null: nothing of it is seen
    const BlockRanges* ranges = nullptr;    ///< of the same blocks; null with them
};

class GridSights {
  public:
    /// `samples`: the plan's. Works in parallel.
    GridSight of(const FieldPlan& plan, const CorrectedField& samples);
    /// Gives up what belongs to fields that nobody else holds any more.
    void dropExpired();

  private:
    struct Visible {
        Curve opacity;
        VisibleBlocks blocks;
    };
    struct Resident {
        std::weak_ptr<const GridField> grid;
        const GridField* key;
        bool corrected, mixed;
        BlockRanges ranges;
        std::list<Visible> visible;  ///< used last first
    };
    static constexpr std::size_t kept = 16;  ///< more than a picture has layers

    Resident& resident(const CorrectedField& samples);

    TransferTables tables_;
    std::list<Resident> fields_;
};

}  // namespace mote::render
