// SPDX-License-Identifier: GPL-3.0-or-later
//
// PackedMoves: the moves of a stipple hierarchy in a few bytes each. A move is the step from one removal of a
// neighbour to the next, and a vector in units of a small part of the moves at that density; a vector is
// measured from where the ones before it led as they are stored, so errors do not add up. Immutable once
// made; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "storage/stipple/stipple_hierarchy.h"

namespace mote::render {

class PackedMoves {
  public:
    explicit PackedMoves(const storage::StippleHierarchy& hierarchy);

    /// The moves of one point, in their order.
    class Walk {
      public:
        /// The removal of the next move's neighbour; nothing at the end.
        std::optional<std::uint32_t> next();
        /// Makes that move. Every move is made or is the last to be looked at.
        void make();
        /// World units.
        const glm::vec3& position() const { return position_; }

      private:
        friend class PackedMoves;
        const PackedMoves* moves_ = nullptr;
        const std::uint8_t* at_ = nullptr;
        const std::uint8_t* end_ = nullptr;
        std::uint32_t removal_ = ~std::uint32_t{0};
        std::uint32_t kind_ = 0;
        glm::vec3 position_{0};
    };
    /// The walk from the point's first position.
    Walk walk(std::size_t point, const glm::vec3& first) const;

    /// The most by which a stored position differs from the hierarchy's in each coordinate, for moves that
    /// were made when `left` points were left. World units.
    float error(std::uint32_t left) const;

    /// Bytes that it takes.
    std::size_t bytes() const;

  private:
    void findUnits(const storage::StippleHierarchy& hierarchy);
    void pack(const storage::StippleHierarchy& hierarchy, std::size_t point);
    float unitAt(std::uint32_t removal) const;

    std::uint32_t points_ = 0;
    int dimensions_ = 3;            ///< 2 if all z are 0
    std::array<float, 33> unit_{};  ///< by the bits of how many points are left; world units
    std::vector<std::uint8_t> bytes_;
    std::vector<std::uint64_t> block_;  ///< where the moves of every 4096th point begin
    std::vector<std::uint32_t> begin_;  ///< where each point's begin, from its block on; one more at the end
};

}  // namespace mote::render
