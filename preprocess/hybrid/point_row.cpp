// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/point_row.h"

#include <numeric>

namespace mote::prep {
namespace {

/// Calls visit(array) for each array of a row, those of larger numbers first.
template <class Row, class Visit>
void eachArray(Row& row, const Visit& visit) {
    visit(row.brickCount);
    visit(row.place);
    visit(row.value);
    visit(row.error);
    visit(row.normal);
    visit(row.least);
}

}  // namespace

Result<PointPiece> PointRow::store(storage::ScratchFile& scratch) const {
    std::vector<std::byte> all;
    eachArray(*this, [&](const auto& array) {
        const auto bytes = std::as_bytes(std::span(array));
        all.insert(all.end(), bytes.begin(), bytes.end());
    });
    MOTE_ASSIGN_OR_RETURN(const auto at, scratch.append(all));
    PointPiece piece;
    piece.offset = at;
    piece.points = place.size();
    piece.least = std::accumulate(least.begin(), least.end(), std::uint64_t{0});
    return piece;
}

Result<PointRow> PointRow::load(const PointPiece& piece, std::size_t bricks,
                                const storage::ScratchFile& scratch) {
    PointRow row;
    eachArray(row, [&](auto& array) { array.resize(piece.points); });
    row.brickCount.resize(bricks);
    auto at = piece.offset;
    Status status = success();
    eachArray(row, [&](auto& array) {
        const auto bytes = std::as_writable_bytes(std::span(array));
        if (status.ok()) status = scratch.read(at, bytes);
        at += bytes.size();
    });
    if (!status.ok()) return status.error();
    return row;
}

}  // namespace mote::prep
