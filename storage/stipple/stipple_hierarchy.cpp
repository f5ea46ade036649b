// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/stipple/stipple_hierarchy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "storage/arrays/array_file.h"
#include "storage/manifest.h"
#include "storage/places.h"

namespace mote::storage {
namespace {

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
    MOTE_RETURN_IF_ERROR(same("/points/rank", h.removal.size(), points));
    MOTE_RETURN_IF_ERROR(same("/points/death_area", h.deathArea.size(), points));
    MOTE_RETURN_IF_ERROR(same("/points/locked", h.locked.size(), points));
    MOTE_RETURN_IF_ERROR(same("/points/moves_begin", h.movesBegin.size(), points + 1));
    return same("/moves/position", h.movePosition.size(), h.moveNeighbour.size());
}

Status checkPlaces(const char* array, const std::vector<glm::vec3>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (isPlace(values[i])) continue;
        return corrupt(array, fmt::format("entry {} is no place: a coordinate is not finite or beyond {:g}",
                                          i, mostCoordinate));
    }
    return success();
}

/// A little more than unit length: what is rounded to floats, and added to places.
Status checkNormals(const std::vector<glm::vec3>& normals) {
    constexpr double most = 1.001;
    for (std::size_t i = 0; i < normals.size(); ++i) {
        if (glm::length(glm::dvec3(normals[i])) <= most) continue;  // no NaN, either
        return corrupt("/points/normal", fmt::format("entry {} is longer than a unit vector", i));
    }
    return success();
}

Status checkPoints(const StippleHierarchy& h) {
    std::vector<bool> seen(h.size());
    for (std::size_t i = 0; i < h.size(); ++i) {
        const auto removal = h.removal[i];
        if (removal >= h.size() || seen[removal]) {
            return corrupt("/points/rank",
                           fmt::format("is no permutation: entry {} is out of range or there twice", i));
        }
        seen[removal] = true;
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
        const std::int64_t removal = h.removal[neighbour];
        if (removal <= last || removal >= h.removal[point]) {
            return corrupt("/moves/neighbour",
                           fmt::format("entry {} is not in the order of removal of point {}", m, point));
        }
        last = removal;
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

static_assert(sizeof(glm::vec3) == 3 * sizeof(float));

std::span<const float> numbers(const std::vector<glm::vec3>& vectors) {
    return {reinterpret_cast<const float*>(vectors.data()), 3 * vectors.size()};
}

/// Copies an array of the file into `out`.
template <class Number, class Value>
Status read(const ArrayFile& file, const char* name, const std::vector<std::uint64_t>& shape,
            std::vector<Value>& out) {
    MOTE_ASSIGN_OR_RETURN(const auto values, file.get<Number>(name, shape));
    const auto* first = reinterpret_cast<const Value*>(values.data());
    out.assign(first, first + values.size_bytes() / sizeof(Value));
    return success();
}

Status readArrays(const ArrayFile& file, std::uint64_t points, std::uint64_t moves, StippleHierarchy& h) {
    MOTE_RETURN_IF_ERROR(read<float>(file, "/points/position", {points, 3}, h.positions));
    MOTE_RETURN_IF_ERROR(read<float>(file, "/points/normal", {points, 3}, h.normals));
    MOTE_RETURN_IF_ERROR(read<std::uint32_t>(file, "/points/rank", {points}, h.removal));
    MOTE_RETURN_IF_ERROR(read<float>(file, "/points/death_area", {points}, h.deathArea));
    MOTE_RETURN_IF_ERROR(read<std::uint8_t>(file, "/points/locked", {points}, h.locked));
    MOTE_RETURN_IF_ERROR(read<std::uint64_t>(file, "/points/moves_begin", {points + 1}, h.movesBegin));
    MOTE_RETURN_IF_ERROR(read<std::uint32_t>(file, "/moves/neighbour", {moves}, h.moveNeighbour));
    return read<float>(file, "/moves/position", {moves, 3}, h.movePosition);
}

}  // namespace

std::uint64_t StippleHierarchy::bytes() const {
    const auto of = [](const auto& values) { return values.capacity() * sizeof(values[0]); };
    return of(positions) + of(normals) + of(removal) + of(deathArea) + of(locked) + of(movesBegin) +
           of(moveNeighbour) + of(movePosition);
}

Status checkHierarchy(const StippleHierarchy& hierarchy) {
    MOTE_RETURN_IF_ERROR(checkSizes(hierarchy));
    MOTE_RETURN_IF_ERROR(checkPlaces("/points/position", hierarchy.positions));
    MOTE_RETURN_IF_ERROR(checkNormals(hierarchy.normals));
    MOTE_RETURN_IF_ERROR(checkPlaces("/moves/position", hierarchy.movePosition));
    MOTE_RETURN_IF_ERROR(checkPoints(hierarchy));
    return checkMoves(hierarchy);
}

Status writeHierarchy(const std::filesystem::path& directory, const StippleHierarchy& h) {
    const std::uint64_t points = h.size();
    const std::uint64_t moves = h.moveNeighbour.size();
    const ArrayFileContent content{
        {"/points", "/moves"},
        {arrayContent("/points/position", {points, 3}, numbers(h.positions)),
         arrayContent("/points/normal", {points, 3}, numbers(h.normals)),
         arrayContent("/points/rank", {points}, std::span(h.removal)),
         arrayContent("/points/death_area", {points}, std::span(h.deathArea)),
         arrayContent("/points/locked", {points}, std::span(h.locked)),
         arrayContent("/points/moves_begin", {points + 1}, std::span(h.movesBegin)),
         arrayContent("/moves/neighbour", {moves}, std::span(h.moveNeighbour)),
         arrayContent("/moves/position", {moves, 3}, numbers(h.movePosition))},
        {}};
    return writeArrayFile(directory, hierarchyName, content);
}

Result<StippleHierarchy> readHierarchy(const PathBeneath& directory, const proto::Manifest& manifest) {
    if (!manifest.has_stipple()) {
        return Error{ErrorCode::invalidArgument, directory.string(),
                     fmt::format("is a dataset of kind \"{}\", not a stipple hierarchy", manifest.kind())};
    }
    MOTE_ASSIGN_OR_RETURN(const auto file, ArrayFile::open(directory, manifest, hierarchyName));
    StippleHierarchy hierarchy;
    MOTE_RETURN_IF_ERROR(
        readArrays(file, manifest.stipple().points(), manifest.stipple().moves(), hierarchy));
    MOTE_RETURN_IF_ERROR(file.check());
    const auto checked = checkHierarchy(hierarchy);
    if (!checked.ok()) {
        return Error{checked.error().code, file.where(checked.error().where), checked.error().message};
    }
    return hierarchy;
}

}  // namespace mote::storage
