// SPDX-License-Identifier: GPL-3.0-or-later
//
// BeamPiece and PlanePiece: the particles of a block that take part, some at a time, as the arrays from which
// sums are taken, and such sums. Sums run in eight lanes whatever the machine, so that their bits are the
// same everywhere. One thread at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "protocol/quantity/any_vectors.h"
#include "storage/beam/beam_statistics.h"

namespace mote::storage {

inline constexpr std::size_t lanes = 8;
using Lanes = std::array<double, lanes>;

/// The same, which a compiler keeps in registers as the machine has them.
using LaneVector [[gnu::vector_size(lanes * sizeof(double))]] = double;

inline void load(LaneVector& to, const double* from) {
    std::memcpy(&to, from, sizeof(to));
}

inline double sumOf(const Lanes& l) {
    return ((l[0] + l[4]) + (l[2] + l[6])) + ((l[1] + l[5]) + (l[3] + l[7]));
}

/// Rows of `N` variables, at most `mostRows`. Beyond `count` lie copies of the first row, without weight.
template <std::size_t N, std::size_t mostRows>
struct PieceRows {
    static constexpr std::size_t variables = N, most = mostRows;
    using Values = std::array<double, most>;

    std::size_t count = 0;  ///< particles
    std::size_t size = 0;   ///< up to a multiple of `lanes`
    alignas(64) std::array<Values, N> value;
    alignas(64) Values weight;
};

/// Rows with all that is summed. So few that they and their sums fit a core's first cache.
struct BeamPiece : PieceRows<11, 128> {
    enum Variable : std::size_t { x, px, y, py, z, pz, energy, p, t, xp, yp };
    bool slopes = false;  ///< whether xp and yp of all rows are finite
};

/// x px y py z pz.
using PlanePiece = PieceRows<6, 1024>;

/// Bit c: the rows have coordinate c.
std::uint32_t knownCoordinates(const BeamRows& rows);

/// Those of rows [begin, begin + count), at most piece.most, that take part, in order. What is not known is
/// 0.
void loadPiece(const BeamRows& rows, std::size_t begin, std::size_t count, double mass, BeamPiece& piece);
void loadPiece(const BeamRows& rows, std::size_t begin, std::size_t count, PlanePiece& piece);

/// Leaves out the rows of which a slope is not finite.
void keepSlopes(BeamPiece& piece);

}  // namespace mote::storage
