// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/point_collector.h"

#include <oneapi/tbb/concurrent_vector.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "preprocess/first_error.h"

namespace mote::prep {
namespace {

constexpr std::uint32_t side = storage::pointBrickSide;

}  // namespace

std::uint8_t PointCoding::valueCode(float value) const {
    if (!(valueSpan > 0.0)) return 0;
    const double code = (value - valueMin) / valueSpan * (storage::pointValueCodes - 1);
    return static_cast<std::uint8_t>(std::clamp(std::floor(code + 0.5), 0.0, 255.0));
}

std::uint8_t PointCoding::errorCode(float error) const {
    if (!(errorStep > 0.0)) return storage::errorCodeZero;
    const double code = std::floor(error / errorStep + 0.5) + storage::errorCodeZero;
    return static_cast<std::uint8_t>(std::clamp(code, 0.0, 255.0));
}

PointCollector::PointCollector(const VolumePlan& plan, const PointCoding& coding,
                               const ErrorSelection& selection, storage::ScratchFile& scratch)
    : plan_(plan),
      bricks_(storage::bricksOf(plan.error, side)),
      coding_(coding),
      selection_(selection),
      scratch_(scratch),
      normals_(plan.error, gridToWorld(plan, plan.error)) {}

Status PointCollector::add(const ErrorSlab& slab) {
    MOTE_CHECK(slab.z0 / side == (slab.z1 - 1) / side);
    FirstError failure;
    tbb::concurrent_vector<PointPiece> pieces;
    tbb::parallel_for(std::uint32_t{0}, bricks_[1], [&](std::uint32_t row) {
        const auto points = collect(row, slab);
        if (points.place.empty()) return;
        auto piece = points.store(scratch_);
        if (!piece.ok()) return failure.set(piece.error());
        piece->layer = slab.z0 / side;
        piece->row = row;
        piece->z = slab.z0;
        pieces.push_back(*piece);
    });
    pieces_.insert(pieces_.end(), pieces.begin(), pieces.end());
    return failure.status();
}

PointRow PointCollector::collect(std::uint32_t row, const ErrorSlab& slab) const {
    PointRow points;
    for (std::uint32_t bx = 0; bx < bricks_[0]; ++bx) {
        points.brickCount.push_back(addBrick(bx, row, slab, points));
    }
    return points;
}

std::uint32_t PointCollector::addBrick(std::uint32_t bx, std::uint32_t by, const ErrorSlab& slab,
                                       PointRow& to) const {
    const auto before = to.place.size();
    const auto right = std::min(plan_.error[0], (bx + 1) * side);
    const auto back = std::min(plan_.error[1], (by + 1) * side);
    for (auto z = slab.z0; z < slab.z1; ++z) {
        const auto values = slab.values(z);
        for (auto y = by * side; y < back; ++y) {
            const auto row = std::size_t{y} * plan_.error[0];
            const auto* errors = slab.error(z) + row;
            for (auto x = bx * side; x < right; ++x) {
                const float error = errors[x];
                if (!selection_.takes(error)) continue;
                to.place.push_back(
                    static_cast<std::uint16_t>(x % side + side * (y % side) + side * side * (z % side)));
                to.value.push_back(coding_.valueCode(values[1][row + x]));
                to.error.push_back(coding_.errorCode(error));
                to.normal.push_back(normals_.code(values, {x, y, z}));
                to.least.push_back(std::abs(error) == selection_.least ? 1 : 0);
            }
        }
    }
    return static_cast<std::uint32_t>(to.place.size() - before);
}

}  // namespace mote::prep
