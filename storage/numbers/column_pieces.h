// SPDX-License-Identifier: GPL-3.0-or-later
//
// The values of a step's points, in pieces of bounded size: docs/PROTOCOL.md, "Numbers". Values and functions
// without state.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "storage/beam/quantity_reader.h"
#include "storage/numbers/point_mask.h"
#include "storage/numbers/run_steps.h"

namespace mote::storage {

struct ColumnPiece {
    std::vector<std::uint8_t> bytes;  ///< column after column: f64, little-endian; of "id" u64
    std::uint64_t rows = 0;
    std::uint64_t next = 0;  ///< where to go on
    bool end = false;        ///< there is no more
};

/// Columns, derived quantities or "id", made ready for a step, which outlives it. Immutable; any number of
/// threads.
class ColumnReader {
  public:
    /// Errors: notFound, at "names[2]".
    static Result<ColumnReader> make(const StepNumbers& step, std::span<const std::string> names);

    const std::vector<std::string>& units() const { return units_; }  ///< by name
    /// Rows of at most so many bytes; at least one.
    std::uint64_t rowsIn(std::uint64_t bytes) const;

    /// From the point `begin` on, those that are chosen (null: all), at most `most` of them out of at most
    /// `looked` points. Errors: cancelled. Throws StorageError.
    Result<ColumnPiece> read(std::uint64_t begin, std::uint64_t looked, std::uint64_t most,
                             const PointMask* chosen, const std::function<bool()>& cancelled) const;
    /// A row for each of the ids, which ascend: of the first of its points, NaN where there is none. next
    /// and end are not said. Errors: cancelled, notFound (there are no ids). Throws StorageError.
    Result<ColumnPiece> readIds(std::span<const std::uint64_t> ids,
                                const std::function<bool()>& cancelled) const;

  private:
    ColumnReader(const ParticleColumns& columns, QuantityReader reader)
        : columns_(&columns), reader_(std::move(reader)) {}

    const ParticleColumns* columns_;
    QuantityReader reader_;                           // of all but "id"
    std::vector<std::optional<std::size_t>> places_;  // by name: which of the reader's; none: "id"
    std::vector<std::string> units_;
};

}  // namespace mote::storage
