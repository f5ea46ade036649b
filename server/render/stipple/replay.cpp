// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/stipple/replay.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace mote::render {
namespace {

using Range = tbb::blocked_range<std::size_t>;
constexpr std::size_t grain = 4096;  // points: below some ten microseconds a task costs more than it brings

}  // namespace

StippleReplay::StippleReplay(storage::StippleHierarchy hierarchy) : hierarchy_(std::move(hierarchy)) {}

std::vector<std::uint8_t> StippleReplay::select(std::span<const float> shares) const {
    MOTE_CHECK(shares.size() == size());
    std::vector<std::uint8_t> drawn(size());
    tbb::parallel_for(Range(0, size(), grain), [&](const Range& range) {
        for (auto i = range.begin(); i != range.end(); ++i) drawn[i] = selects(i, shares[i]) ? 1 : 0;
    });
    return drawn;
}

glm::vec3 StippleReplay::placed(std::size_t point, std::span<const std::uint8_t> drawn) const {
    const auto& h = hierarchy_;
    auto move = h.movesBegin[point];
    while (move < h.movesBegin[point + 1] && drawn[h.moveNeighbour[move]] == 0) ++move;
    return move == h.movesBegin[point] ? h.positions[point] : h.movePosition[move - 1];
}

std::vector<PlacedPoint> StippleReplay::place(std::span<const std::uint8_t> drawn) const {
    MOTE_CHECK(drawn.size() == size());
    std::vector<PlacedPoint> points;
    for (std::uint32_t i = 0; i < size(); ++i) {
        if (drawn[i] != 0) points.push_back({i, {}});
    }
    tbb::parallel_for(Range(0, points.size(), grain), [&](const Range& range) {
        for (auto i = range.begin(); i != range.end(); ++i) {
            points[i].position = placed(points[i].point, drawn);
        }
    });
    return points;
}

}  // namespace mote::render
