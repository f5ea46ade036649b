// SPDX-License-Identifier: GPL-3.0-or-later
//
// The points of a hybrid volume: put aside row of bricks by row while an error pass goes by, then written
// into the step's file in one of their forms, a row at a time. A PointCollector has one owner and works on
// the caller's oneTBB threads.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "preprocess/hybrid/error_pass.h"
#include "preprocess/hybrid/low_volume.h"
#include "protocol/base/error.h"
#include "storage/files/dataset_file.h"
#include "storage/hybrid/hybrid_file.h"

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

/// The points of a row of bricks along x, as they are collected, put aside and joined again. A
/// value.
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

/// What a point's bytes mean.
struct PointCoding {
    double valueMin = 0.0, valueSpan = 0.0;  ///< of the source
    double errorStep = 0.0;

    std::uint8_t valueCode(float value) const;
    std::uint8_t errorCode(float error) const;
};

class PointCollector {
  public:
    /// `plan` and `scratch` must outlive this.
    PointCollector(const VolumePlan& plan, const PointCoding& coding, const ErrorSelection& selection,
                   storage::ScratchFile& scratch);

    /// A slab that lies in one layer of bricks. Errors: as ScratchFile::append.
    Status add(const ErrorSlab& slab);
    /// What was put aside so far; in no order.
    const std::vector<PointPiece>& pieces() const { return pieces_; }

  private:
    PointRow collect(std::uint32_t row, const ErrorSlab& slab) const;
    std::uint32_t addBrick(std::uint32_t bx, std::uint32_t by, const ErrorSlab& slab, PointRow& to) const;

    const VolumePlan& plan_;
    storage::GridSize bricks_;
    PointCoding coding_;
    ErrorSelection selection_;
    storage::ScratchFile& scratch_;
    GradientNormals normals_;
    std::vector<PointPiece> pieces_;
};

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
