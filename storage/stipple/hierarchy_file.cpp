// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/stipple/hierarchy_file.h"

#include <fmt/format.h>

#include "storage/arrays/array_file.h"
#include "storage/manifest.h"

namespace mote::storage {
namespace {

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
    MOTE_RETURN_IF_ERROR(read<std::uint32_t>(file, "/points/rank", {points}, h.rank));
    MOTE_RETURN_IF_ERROR(read<float>(file, "/points/death_area", {points}, h.deathArea));
    MOTE_RETURN_IF_ERROR(read<std::uint8_t>(file, "/points/locked", {points}, h.locked));
    MOTE_RETURN_IF_ERROR(read<std::uint64_t>(file, "/points/moves_begin", {points + 1}, h.movesBegin));
    MOTE_RETURN_IF_ERROR(read<std::uint32_t>(file, "/moves/neighbour", {moves}, h.moveNeighbour));
    return read<float>(file, "/moves/position", {moves, 3}, h.movePosition);
}

}  // namespace

Status writeHierarchy(const std::filesystem::path& directory, const StippleHierarchy& h) {
    const std::uint64_t points = h.size();
    const std::uint64_t moves = h.moveNeighbour.size();
    const ArrayFileContent content{
        {"/points", "/moves"},
        {arrayContent("/points/position", {points, 3}, numbers(h.positions)),
         arrayContent("/points/normal", {points, 3}, numbers(h.normals)),
         arrayContent("/points/rank", {points}, std::span(h.rank)),
         arrayContent("/points/death_area", {points}, std::span(h.deathArea)),
         arrayContent("/points/locked", {points}, std::span(h.locked)),
         arrayContent("/points/moves_begin", {points + 1}, std::span(h.movesBegin)),
         arrayContent("/moves/neighbour", {moves}, std::span(h.moveNeighbour)),
         arrayContent("/moves/position", {moves, 3}, numbers(h.movePosition))},
        {}};
    return writeArrayFile(directory, hierarchyName, content);
}

Result<StippleHierarchy> readHierarchy(const std::filesystem::path& directory,
                                       const proto::Manifest& manifest) {
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
