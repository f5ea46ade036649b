// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/point_collector.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace mote::prep {
namespace {

constexpr std::uint32_t side = storage::pointBrickSide;

template <class T>
void appendTo(std::vector<T>& to, const std::vector<T>& from) {
    to.insert(to.end(), from.begin(), from.end());
}

/// Keeps the elements whose `keep` is not zero.
template <class T>
void filter(std::vector<T>& values, const std::vector<std::uint8_t>& keep) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (keep[i]) values[kept++] = values[i];
    }
    values.resize(kept);
}

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

void CollectedPoints::append(const CollectedPoints& next) {
    appendTo(brickCount, next.brickCount);
    appendTo(place, next.place);
    appendTo(value, next.value);
    appendTo(error, next.error);
    appendTo(normal, next.normal);
    appendTo(least, next.least);
}

void CollectedPoints::limitLeast(std::uint64_t most) {
    std::vector<std::uint8_t> keep(least.size(), 1);
    std::size_t point = 0;
    for (auto& count : brickCount) {
        const auto end = point + count;
        for (; point < end; ++point) {
            if (least[point] == 0) continue;
            keep[point] = most > 0 ? 1 : 0;
            if (most > 0) --most;
            count -= keep[point] ? 0 : 1;
        }
    }
    filter(place, keep);
    filter(value, keep);
    filter(error, keep);
    filter(normal, keep);
    filter(least, keep);
}

PointCollector::PointCollector(const VolumePlan& plan, const PointCoding& coding,
                               const ErrorSelection& selection)
    : plan_(plan),
      bricks_(storage::bricksOf(plan.error, side)),
      coding_(coding),
      selection_(selection),
      normals_(plan.error, gridToWorld(plan, plan.error)),
      layer_(std::size_t{bricks_[0]} * bricks_[1]) {}

void PointCollector::add(const ErrorSlab& slab) {
    // A slab of several layers would not keep the order.
    MOTE_CHECK(slab.z0 / side == (slab.z1 - 1) / side);
    tbb::parallel_for(std::uint32_t{0}, bricks_[1], [&](std::uint32_t by) {
        for (std::uint32_t bx = 0; bx < bricks_[0]; ++bx) addTo(bx, by, slab);
    });
    pending_ = 0;
    for (const auto& brick : layer_) pending_ += brick.size();
    if (slab.z1 % side == 0 || slab.z1 == plan_.error[2]) finishLayer();
}

void PointCollector::addTo(std::uint32_t bx, std::uint32_t by, const ErrorSlab& slab) {
    auto& brick = layer_[std::size_t{by} * bricks_[0] + bx];
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
                brick.place.push_back(
                    static_cast<std::uint16_t>(x % side + side * (y % side) + side * side * (z % side)));
                brick.value.push_back(coding_.valueCode(values[1][row + x]));
                brick.error.push_back(coding_.errorCode(error));
                brick.normal.push_back(normals_.code(values, {x, y, z}));
                brick.least.push_back(std::abs(error) == selection_.least ? 1 : 0);
            }
        }
    }
}

void PointCollector::finishLayer() {
    for (auto& brick : layer_) {
        brick.brickCount.assign(1, brick.size());
        done_.append(brick);
        brick = {};
    }
    pending_ = 0;
}

CollectedPoints PointCollector::take() {
    MOTE_CHECK(pending_ == 0);
    return std::exchange(done_, {});
}

}  // namespace mote::prep
