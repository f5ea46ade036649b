// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/stipple/stipple_hierarchy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace mote::storage {
namespace {

Error corrupt(const char* array, std::string message) {
    return {ErrorCode::corrupt, array, std::move(message)};
}

Status checkSizes(const StippleHierarchy& h) {
    const auto points = h.size();
    if (points < 1 || points > std::numeric_limits<std::uint32_t>::max()) {
        return corrupt("/points/position", fmt::format("has {} points", points));
    }
    const auto same = [](const char* array, std::size_t size, std::size_t expected) -> Status {
        if (size == expected) return success();
        return corrupt(array, fmt::format("has {} entries, not {}", size, expected));
    };
    MOTE_RETURN_IF_ERROR(same("/points/normal", h.normals.size(), points));
    MOTE_RETURN_IF_ERROR(same("/points/rank", h.rank.size(), points));
    MOTE_RETURN_IF_ERROR(same("/points/death_area", h.deathArea.size(), points));
    MOTE_RETURN_IF_ERROR(same("/points/locked", h.locked.size(), points));
    MOTE_RETURN_IF_ERROR(same("/points/moves_begin", h.movesBegin.size(), points + 1));
    return same("/moves/position", h.movePosition.size(), h.moveNeighbour.size());
}

Status checkFinite(const char* array, const std::vector<glm::vec3>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto& v = values[i];
        if (std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z)) continue;
        return corrupt(array, fmt::format("entry {} is not a finite vector", i));
    }
    return success();
}

Status checkPoints(const StippleHierarchy& h) {
    std::vector<bool> seen(h.size());
    for (std::size_t i = 0; i < h.size(); ++i) {
        const auto rank = h.rank[i];
        if (rank >= h.size() || seen[rank]) {
            return corrupt("/points/rank",
                           fmt::format("is no permutation: entry {} is out of range or there twice", i));
        }
        seen[rank] = true;
        if (!(h.deathArea[i] >= 0.0F) || !std::isfinite(h.deathArea[i])) {
            return corrupt("/points/death_area", fmt::format("entry {} is no area", i));
        }
        if (h.locked[i] > 1) return corrupt("/points/locked", fmt::format("entry {} is not 0 or 1", i));
    }
    return success();
}

Status checkMovesOf(const StippleHierarchy& h, std::size_t point) {
    std::int64_t last = -1;
    for (auto m = h.movesBegin[point]; m < h.movesBegin[point + 1]; ++m) {
        const auto neighbour = h.moveNeighbour[m];
        if (neighbour >= h.size()) {
            return corrupt("/moves/neighbour", fmt::format("entry {} is not one of the points", m));
        }
        const std::int64_t rank = h.rank[neighbour];
        if (rank <= last || rank >= h.rank[point]) {
            return corrupt("/moves/neighbour",
                           fmt::format("entry {} is not in the order of removal of point {}", m, point));
        }
        last = rank;
    }
    return success();
}

Status checkMoves(const StippleHierarchy& h) {
    const auto& begin = h.movesBegin;
    // Ascending from 0 to M, before anything is looked up by it.
    if (begin.front() != 0 || begin.back() != h.moveNeighbour.size() ||
        !std::is_sorted(begin.begin(), begin.end())) {
        return corrupt("/points/moves_begin", "does not ascend from 0 to the number of moves");
    }
    for (std::size_t point = 0; point < h.size(); ++point) MOTE_RETURN_IF_ERROR(checkMovesOf(h, point));
    return success();
}

}  // namespace

std::uint64_t StippleHierarchy::bytes() const {
    const auto of = [](const auto& values) { return values.capacity() * sizeof(values[0]); };
    return of(positions) + of(normals) + of(rank) + of(deathArea) + of(locked) + of(movesBegin) +
           of(moveNeighbour) + of(movePosition);
}

Status checkHierarchy(const StippleHierarchy& hierarchy) {
    MOTE_RETURN_IF_ERROR(checkSizes(hierarchy));
    MOTE_RETURN_IF_ERROR(checkFinite("/points/position", hierarchy.positions));
    MOTE_RETURN_IF_ERROR(checkFinite("/points/normal", hierarchy.normals));
    MOTE_RETURN_IF_ERROR(checkFinite("/moves/position", hierarchy.movePosition));
    MOTE_RETURN_IF_ERROR(checkPoints(hierarchy));
    return checkMoves(hierarchy);
}

}  // namespace mote::storage
