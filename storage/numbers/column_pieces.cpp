// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/column_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "storage/numbers/id_set.h"
#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::uint64_t valueBytes = 8;

/// A value of a piece.
void put(ColumnPiece& piece, std::uint64_t rows, std::size_t name, std::uint64_t row, std::uint64_t bits) {
    std::memcpy(piece.bytes.data() + (name * rows + row) * valueBytes, &bits, valueBytes);
}

}  // namespace

Result<ColumnReader> ColumnReader::make(const StepNumbers& step, std::span<const std::string> names) {
    std::vector<std::string> quantities;
    std::vector<std::size_t> fields;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] == "id") continue;
        quantities.push_back(names[i]);
        fields.push_back(i);
    }
    auto reader = QuantityReader::make(*step.columns, step.context, quantities);
    if (!reader.ok()) {
        const auto& error = reader.error();  // at the name
        const auto at = std::ranges::find(names, error.where);
        return Error{error.code, fmt::format("names[{}]", at - names.begin()),
                     fmt::format("\"{}\" {}", error.where, error.message)};
    }
    ColumnReader made(*step.columns, *std::move(reader));
    std::size_t next = 0;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i] != "id") {
            made.units_.push_back(made.reader_.units()[next]);
            made.places_.emplace_back(next++);
            continue;
        }
        if (!step.columns->hasIds()) return withoutIds(fmt::format("names[{}]", i));
        made.units_.emplace_back("1");
        made.places_.emplace_back(std::nullopt);
    }
    return made;
}

std::uint64_t ColumnReader::rowsIn(std::uint64_t bytes) const {
    return std::max<std::uint64_t>(1, bytes / (valueBytes * std::max<std::size_t>(1, places_.size())));
}

Result<ColumnPiece> ColumnReader::read(std::uint64_t begin, std::uint64_t looked, std::uint64_t most,
                                       const PointMask* chosen,
                                       const std::function<bool()>& cancelled) const {
    const auto points = columns_->pointCount();
    ColumnPiece piece;
    piece.next = std::min(begin, points);
    const auto end = piece.next + std::min(looked, points - piece.next);
    QuantityReader::Scratch scratch;
    std::vector<std::vector<double>> values(reader_.size(), std::vector<double>(blockPoints));
    std::vector<std::span<double>> out(reader_.size());
    std::vector<std::vector<std::uint64_t>> rows(places_.size());  // by name
    while (piece.next < end && piece.rows < most) {
        if (cancelled && cancelled()) return wasCancelled();
        // Blocks of this function's own: they begin where the client says.
        const auto count =
            std::min({blockPoints, end - piece.next, chosen != nullptr ? blockPoints : most - piece.rows});
        std::vector<std::size_t> taken;
        for (std::size_t i = 0; i < count && piece.rows + taken.size() < most; ++i) {
            if (chosen == nullptr || chosen->chosen(piece.next + i)) taken.push_back(i);
        }
        const bool full = piece.rows + taken.size() == most;
        if (!taken.empty()) {
            for (std::size_t k = 0; k < out.size(); ++k) out[k] = std::span(values[k]).first(count);
            reader_.read(piece.next, count, scratch, out);
            for (std::size_t name = 0; name < places_.size(); ++name) {
                const auto ids =
                    places_[name] ? std::span<const std::uint64_t>() : columns_->ids(piece.next, count);
                for (const auto i : taken)
                    rows[name].push_back(
                        places_[name] ? std::bit_cast<std::uint64_t>(values[*places_[name]][i]) : ids[i]);
            }
        }
        piece.rows += taken.size();
        piece.next += full && !taken.empty() ? taken.back() + 1 : count;
    }
    piece.end = piece.next >= points;
    piece.bytes.resize(places_.size() * piece.rows * valueBytes);
    for (std::size_t name = 0; name < rows.size(); ++name) {
        if (piece.rows > 0)
            std::memcpy(piece.bytes.data() + name * piece.rows * valueBytes, rows[name].data(),
                        piece.rows * valueBytes);
    }
    return piece;
}

Result<ColumnPiece> ColumnReader::readIds(std::span<const std::uint64_t> ids,
                                          const std::function<bool()>& cancelled) const {
    if (!columns_->hasIds()) return withoutIds("byId");
    const auto points = firstPoints(ids, *columns_, cancelled);
    if (!points) return wasCancelled();
    ColumnPiece piece;
    piece.rows = ids.size();
    piece.bytes.resize(places_.size() * piece.rows * valueBytes);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const bool whole = forBlocks(blockCount(ids.size()), cancelled, [&](std::uint64_t block) {
        const auto part = pointsOfBlock(block, ids.size());
        QuantityReader::Scratch scratch;
        std::vector<double> values(reader_.size(), nan);
        std::vector<std::span<double>> out;
        for (auto& value : values) out.emplace_back(&value, 1);
        for (auto row = part.begin; row < part.begin + part.count; ++row) {
            const auto point = (*points)[row];
            if (point != noPoint)
                reader_.read(point, 1, scratch, out);
            else
                std::ranges::fill(values, nan);
            for (std::size_t name = 0; name < places_.size(); ++name)
                put(piece, piece.rows, name, row,
                    places_[name] ? std::bit_cast<std::uint64_t>(values[*places_[name]]) : ids[row]);
        }
    });
    if (!whole) return wasCancelled();
    return piece;
}

}  // namespace mote::storage
