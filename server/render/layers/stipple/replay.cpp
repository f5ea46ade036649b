// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/replay.h"

#include <algorithm>

#include "server/render/plan/in_turns.h"

namespace mote::render {
namespace {

using Range = tbb::blocked_range<std::size_t>;
constexpr std::size_t replayedPerTask =
    4096;  // points: below some ten microseconds a task costs more than it brings

}  // namespace

StippleReplay::StippleReplay(const storage::StippleHierarchy& hierarchy)
    : positions_(hierarchy.positions),
      normals_(hierarchy.normals),
      removal_(hierarchy.removal),
      pointOfRemoval_(hierarchy.size()),
      moves_(hierarchy) {
    if (std::all_of(normals_.begin(), normals_.end(), [&](const auto& n) { return n == normals_[0]; })) {
        normals_.resize(1);
        normals_.shrink_to_fit();
    }
    for (std::uint32_t point = 0; point < size(); ++point) pointOfRemoval_[removal_[point]] = point;
}

std::size_t StippleReplay::bytes() const {
    return (positions_.capacity() + normals_.capacity()) * sizeof(glm::vec3) +
           (removal_.capacity() + pointOfRemoval_.capacity()) * sizeof(std::uint32_t) + moves_.bytes();
}

std::vector<std::uint8_t> StippleReplay::select(std::span<const float> shares) const {
    MOTE_CHECK(shares.size() == size());
    std::vector<std::uint8_t> drawn(size());
    forRangesInTurns(size(), replayedPerTask, [&](const Range& range) {
        for (auto i = range.begin(); i != range.end(); ++i) drawn[i] = selects(i, shares[i]) ? 1 : 0;
    });
    return drawn;
}

glm::vec3 StippleReplay::placed(std::size_t point, std::span<const std::uint8_t> drawn) const {
    auto walk = moves_.walk(point, positions_[point]);
    for (auto removal = walk.next(); removal && drawn[pointOfRemoval_[*removal]] == 0; removal = walk.next())
        walk.make();
    return walk.position();
}

std::vector<PlacedPoint> StippleReplay::place(std::span<const std::uint8_t> drawn) const {
    MOTE_CHECK(drawn.size() == size());
    std::vector<PlacedPoint> points;
    for (std::uint32_t i = 0; i < size(); ++i) {
        if (drawn[i] != 0) points.push_back({i, {}});
    }
    forRangesInTurns(points.size(), replayedPerTask, [&](const Range& range) {
        for (auto i = range.begin(); i != range.end(); ++i) {
            points[i].position = placed(points[i].point, drawn);
        }
    });
    return points;
}

}  // namespace mote::render
