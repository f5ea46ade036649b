// SPDX-License-Identifier: GPL-3.0-or-later
//
// PointCollector: the points of a hybrid volume, brick by brick, while an error pass goes by. One owner;
// works on the caller's oneTBB threads.
#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/volume/error_pass.h"
#include "preprocess/volume/error_selection.h"
#include "preprocess/volume/gradient.h"
#include "storage/hybrid/hybrid_points.h"

namespace mote::prep {

/// What a point's bytes mean.
struct PointCoding {
    double valueMin = 0.0, valueSpan = 0.0;  ///< of the source
    double errorStep = 0.0;

    std::uint8_t valueCode(float value) const;
    std::uint8_t errorCode(float error) const;
};

/// Points by their bricks, x fastest, in ascending order of their places in each.
struct CollectedPoints {
    std::vector<std::uint64_t> brickCount;
    std::vector<std::uint16_t> place;  ///< in its brick
    std::vector<std::uint8_t> value, error, normal;
    std::vector<std::uint8_t> least;  ///< 1: its error is the least that counts, so it may be one too many

    std::uint64_t size() const { return place.size(); }
    void append(const CollectedPoints& next);
    /// Leaves out those of least error but for the first `most` of them.
    void limitLeast(std::uint64_t most);
};

class PointCollector {
  public:
    /// `plan` must outlive this.
    PointCollector(const VolumePlan& plan, const PointCoding& coding, const ErrorSelection& selection);

    /// The next slab, in ascending order; it need not end where bricks do.
    void add(const ErrorSlab& slab);
    /// All points, once whole layers of bricks came, or the last one. The collector is empty then.
    CollectedPoints take();
    std::uint64_t size() const { return done_.size() + pending_; }

  private:
    void addTo(std::uint32_t bx, std::uint32_t by, const ErrorSlab& slab);
    void finishLayer();

    const VolumePlan& plan_;
    storage::GridSize bricks_;
    PointCoding coding_;
    ErrorSelection selection_;
    GradientNormals normals_;
    std::vector<CollectedPoints> layer_;  ///< bricks of the present layer, x fastest
    std::uint64_t pending_ = 0;           ///< points in the layer
    CollectedPoints done_;
};

}  // namespace mote::prep
