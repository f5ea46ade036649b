// SPDX-License-Identifier: GPL-3.0-or-later
//
// RowWalk: brings the chosen points of a step, as rows of coordinates and weight, to whoever sums them, group
// by group, in blocks that do not depend on the number of threads. Immutable; walk() uses all threads of the
// calling arena.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "storage/beam/beam_statistics.h"
#include "storage/numbers/bin_axis.h"
#include "storage/numbers/point_mask.h"
#include "storage/numbers/run_steps.h"

namespace mote::storage {

class RowWalk {
  public:
    /// What takes rows of a group; called on several threads at once, with their number.
    using Take = std::function<void(std::size_t thread, std::uint32_t group, const BeamRows& rows)>;

    /// `groups`: each point goes to the group of its bin, and those without a bin to none; null: all are one
    /// group. `chosen`: null: all. `quantities`: these, one or two, take the places of x and y, and there are
    /// no other coordinates; null: those of the columns. All outlive this.
    RowWalk(const ParticleColumns& columns, const PointMask* chosen, const BinAxis* groups,
            const QuantityReader* quantities = nullptr);

    std::uint32_t groups() const { return groups_ != nullptr ? groups_->bins() : 1; }
    /// Of the numbers that `take` is called with.
    static std::size_t threads();
    /// False where `cancelled` said to stop. Throws StorageError.
    bool walk(const std::function<bool()>& cancelled, const Take& take) const;

  private:
    static constexpr std::size_t columnsOfRow = BeamRows::coordinates + 1;  // and weight
    class Buffer;
    class Part;

    const ParticleColumns& columns_;
    const PointMask* const chosen_;
    const BinAxis* const groups_;
    const QuantityReader* const quantities_;
    std::array<std::optional<std::size_t>, columnsOfRow> sources_;  ///< columns, or which of the quantities
};

}  // namespace mote::storage
