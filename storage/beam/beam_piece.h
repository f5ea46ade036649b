// SPDX-License-Identifier: GPL-3.0-or-later
//
// BeamPiece: the particles of a block that take part, some at a time, as the arrays from which sums are
// taken, and such sums. Sums run in eight lanes whatever the machine, so that their bits are the same
// everywhere. One thread at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>

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

/// Of term(0) to term(size - 1); `size` is a multiple of `lanes`.
template <class Term>
double laneSum(std::size_t size, const Term& term) {
    Lanes sum{};
    for (std::size_t i = 0; i < size; i += lanes) {
        for (std::size_t k = 0; k < lanes; ++k) sum[k] += term(i + k);
    }
    return sumOf(sum);
}

struct BeamPiece {
    static constexpr std::size_t most = 1024;

    template <std::size_t N>
    struct Rows {
        std::size_t count = 0;  ///< particles
        std::size_t size = 0;   ///< up to a multiple of `lanes`; beyond `count` weights are 0
        alignas(64) std::array<std::array<double, most>, N> value;  ///< x px y py z pz t energy p
        alignas(64) std::array<double, most> weight;
    };
    Rows<BeamMoments::sizeA> a;
    Rows<BeamMoments::sizeB> b;  ///< x xp y yp p of those whose slopes are finite
};

/// Bit c: the rows have coordinate c.
std::uint32_t knownCoordinates(const BeamRows& rows);

/// All particles that take part, in order. What is not known is 0. Without `slopes`, b is not filled.
void forEachPiece(const BeamRows& rows, double mass, bool slopes,
                  const std::function<void(const BeamPiece&)>& use);

}  // namespace mote::storage
