// SPDX-License-Identifier: GPL-3.0-or-later
//
// Collected points into a step's file, in one of their forms, brick by brick. Holds a row of bricks at a
// time. Functions without state.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "preprocess/hybrid/point_row.h"
#include "storage/hybrid/hybrid_file.h"

namespace mote::prep {

/// What was collected, by all ranks.
struct PointPieces {
    std::vector<PointPiece> pieces;  ///< in any order; piece.scratch is an index into `scratches`
    std::span<const std::unique_ptr<storage::ScratchFile>> scratches;
    /// Only the first so many of those of least error are taken, in the order of the bricks.
    std::uint64_t mostOfLeast = 0;

    /// How many are taken.
    std::uint64_t size() const;
};

/// Writes all arrays of the file's points, whose error grid is `grid`, in the form of 5, 6 or 9 `bytes`.
/// `progress` is asked between rows. Errors: its, and as ScratchFile::read and
/// HybridStepWriter::writePoints.
Status writePoints(PointPieces points, const storage::GridSize& grid, std::uint32_t bytes,
                   const std::function<Status()>& progress, const storage::HybridStepWriter& file);

}  // namespace mote::prep
