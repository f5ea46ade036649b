// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointRow: the points of a row of bricks along x, as they are collected, put aside and joined again. A
// value.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/scene/error.h"
#include "storage/files/scratch_file.h"

namespace mote::prep {

/// Where a row, or the slices of it that one slab had, lies in a scratch file. Trivially copyable, so that
/// processes can exchange it.
struct PointPiece {
    std::uint32_t layer = 0, row = 0;  ///< of the bricks, along z and y
    std::uint32_t z = 0;               ///< first slice of the slab
    std::uint32_t scratch = 0;         ///< which file
    std::uint64_t offset = 0;
    std::uint64_t points = 0;
    std::uint64_t least = 0;  ///< those of them of the least error that counts
};

struct PointRow {
    std::vector<std::uint32_t> brickCount;  ///< points of each brick, in whose order all others lie
    std::vector<std::uint16_t> place;       ///< in its brick, ascending in each
    std::vector<std::uint8_t> value, error, normal;
    std::vector<std::uint8_t> least;  ///< 1: its error is the least that counts, so it may be one too many

    /// Puts the row aside; returns where and how much it is. Errors: as ScratchFile::append.
    Result<PointPiece> store(storage::ScratchFile& scratch) const;
    /// Reads a row of `bricks` bricks. Errors: as ScratchFile::read.
    static Result<PointRow> load(const PointPiece& piece, std::size_t bricks,
                                 const storage::ScratchFile& scratch);
};

}  // namespace mote::prep
