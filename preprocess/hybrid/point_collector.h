// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointCollector: the points of a hybrid volume, put aside row of bricks by row while an error pass goes by.
// One owner; works on the caller's oneTBB threads.
#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/hybrid/error_pass.h"
#include "preprocess/hybrid/error_selection.h"
#include "preprocess/hybrid/gradient.h"
#include "preprocess/hybrid/point_row.h"
#include "storage/hybrid/hybrid_points.h"

namespace mote::prep {

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

}  // namespace mote::prep
