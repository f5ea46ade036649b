// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "storage/beam/beam_piece.h"
#include "storage/beam/moment_sums.h"

namespace mote::storage {
namespace {

using moments::join;
using moments::pairIndex;

/// Deviations from the piece's mean; weights are 0 beyond its end.
template <std::size_t N>
struct Centred {
    alignas(64) std::array<std::array<double, BeamPiece::most>, N> deviation;
    std::array<double, N> rest{};  ///< weighted sum of deviations: what the mean lacks
};

// What of a system's sums is known before: of which variables, and of which pairs of them.
struct NothingKnown {
    static constexpr bool variable(std::size_t) { return false; }
    static constexpr bool pair(std::size_t, std::size_t) { return false; }
};
/// In system a, where the time is no column: it is 0, and so are all its sums.
struct NoTime {
    static constexpr bool variable(std::size_t a) { return a == 6; }
    static constexpr bool pair(std::size_t a, std::size_t b) { return variable(a) || variable(b); }
};
/// In system b, where it has all particles of system a: x, y and p are the same.
struct KnownOfA {
    static constexpr std::array<std::size_t, BeamMoments::sizeB> inA{0, 0, 2, 0, 8};
    static constexpr bool variable(std::size_t a) { return a % 2 == 0; }
    static constexpr bool pair(std::size_t a, std::size_t b) { return variable(a) && variable(b); }
};

/// The weighted sums of the products of deviation `a` and those from it on, in one pass: a sum that waits for
/// nothing but itself leaves most of a core idle. Unrolled, all sums stay in registers.
template <class Known, std::size_t a, std::size_t N, class Sums>
void addProductsOf(const BeamPiece::Rows<N>& rows, const Centred<N>& centred, Sums& to) {
    std::array<LaneVector, N - a> sums{};
    for (std::size_t i = 0; i < rows.size; i += lanes) {
        LaneVector weighted, deviation;
        load(weighted, rows.weight.data() + i);
        load(deviation, centred.deviation[a].data() + i);
        weighted *= deviation;
#pragma GCC unroll 16
        for (std::size_t b = a; b < N; ++b) {
            if (Known::pair(a, b)) continue;
            load(deviation, centred.deviation[b].data() + i);
            sums[b - a] += weighted * deviation;
        }
    }
    for (std::size_t b = a; b < N; ++b) {
        if (!Known::pair(a, b)) to[pairIndex<N>(a, b)] = sumOf(std::bit_cast<Lanes>(sums[b - a]));
    }
}

template <class Known, std::size_t N, class Sums, std::size_t... a>
void addProducts(const BeamPiece::Rows<N>& rows, const Centred<N>& centred, Sums& to,
                 std::index_sequence<a...> /*variables*/) {
    (addProductsOf<Known, a>(rows, centred, to), ...);
}

// The following go through all variables at once: a sum of one alone would wait for itself. What is known of
// a variable is left out by a condition that the compiler knows.

/// Beyond the end of the rows lie copies of the first.
template <class Known, std::size_t N>
void findExtremes(const BeamPiece::Rows<N>& rows, BeamMoments::Second<N>& out) {
    std::array<LaneVector, N> least, greatest;
    for (std::size_t a = 0; a < N; ++a) load(least[a], rows.value[a].data());
    greatest = least;
    for (std::size_t i = lanes; i < rows.size; i += lanes) {
#pragma GCC unroll 16
        for (std::size_t a = 0; a < N; ++a) {
            if (Known::variable(a)) continue;
            LaneVector value;
            load(value, rows.value[a].data() + i);
            least[a] = value < least[a] ? value : least[a];
            greatest[a] = value > greatest[a] ? value : greatest[a];
        }
    }
    for (std::size_t a = 0; a < N; ++a) {
        if (Known::variable(a)) continue;
        out.least[a] = std::ranges::min(std::bit_cast<Lanes>(least[a]));
        out.greatest[a] = std::ranges::max(std::bit_cast<Lanes>(greatest[a]));
    }
}

template <class Known, std::size_t N>
void center(const BeamPiece::Rows<N>& rows, BeamMoments::Second<N>& out, Centred<N>& centred) {
    std::array<LaneVector, N> sums{};
    for (std::size_t i = 0; i < rows.size; i += lanes) {
        LaneVector weight, value;
        load(weight, rows.weight.data() + i);
#pragma GCC unroll 16
        for (std::size_t a = 0; a < N; ++a) {
            if (Known::variable(a)) continue;
            load(value, rows.value[a].data() + i);
            sums[a] += weight * value;
        }
    }
    std::array<double, N> mean{};
    for (std::size_t a = 0; a < N; ++a) mean[a] = sumOf(std::bit_cast<Lanes>(sums[a])) / out.weight;
    sums = {};
    for (std::size_t i = 0; i < rows.size; i += lanes) {
        LaneVector weight, value;
        load(weight, rows.weight.data() + i);
#pragma GCC unroll 16
        for (std::size_t a = 0; a < N; ++a) {
            if (Known::variable(a)) continue;
            load(value, rows.value[a].data() + i);
            value -= mean[a];
            std::memcpy(centred.deviation[a].data() + i, &value, sizeof value);
            sums[a] += weight * value;
        }
    }
    for (std::size_t a = 0; a < N; ++a) {
        if (Known::variable(a)) continue;
        centred.rest[a] = sumOf(std::bit_cast<Lanes>(sums[a]));
        out.mean[a] = mean[a] + centred.rest[a] / out.weight;
    }
}

/// What is not known yet.
template <class Known, std::size_t N>
void addUnknown(const BeamPiece::Rows<N>& rows, Centred<N>& centred, BeamMoments::Second<N>& out) {
    findExtremes<Known>(rows, out);
    if (out.weight == 0.0) return;
    center<Known>(rows, out, centred);
    addProducts<Known>(rows, centred, out.sum, std::make_index_sequence<N>());
    for (std::size_t a = 0; a < N; ++a) {
        for (std::size_t b = a; b < N; ++b) {
            if (!Known::pair(a, b))
                out.sum[pairIndex<N>(a, b)] -= centred.rest[a] * (centred.rest[b] / out.weight);
        }
    }
}

template <class Known, std::size_t N>
BeamMoments::Second<N> secondOf(const BeamPiece::Rows<N>& rows, Centred<N>& centred) {
    BeamMoments::Second<N> out;
    out.count = rows.count;
    if (rows.count == 0) return out;
    out.weight = laneSum(rows.size, [&](std::size_t i) { return rows.weight[i]; });
    addUnknown<Known>(rows, centred, out);
    return out;
}

/// Of system b, whose particles are those of system a.
BeamMoments::Second<BeamMoments::sizeB> slopesOf(const BeamPiece& piece,
                                                 const BeamMoments::Second<BeamMoments::sizeA>& a,
                                                 const Centred<BeamMoments::sizeA>& ofA) {
    constexpr auto size = BeamMoments::sizeB;
    BeamMoments::Second<size> out;
    Centred<size> centred;
    out.count = a.count;
    out.weight = a.weight;
    for (std::size_t i = 0; i < size; ++i) {
        if (!KnownOfA::variable(i)) continue;
        const auto from = KnownOfA::inA[i];
        out.least[i] = a.least[from];
        out.greatest[i] = a.greatest[from];
        out.mean[i] = a.mean[from];
        centred.rest[i] = ofA.rest[from];
        if (a.weight > 0.0)
            std::copy_n(ofA.deviation[from].begin(), piece.b.size, centred.deviation[i].begin());
        for (std::size_t j = i; j < size; ++j) {
            if (KnownOfA::pair(i, j))
                out.sum[pairIndex<size>(i, j)] = a.sum[pairIndex<BeamMoments::sizeA>(from, KnownOfA::inA[j])];
        }
    }
    addUnknown<KnownOfA>(piece.b, centred, out);
    return out;
}

/// Third and fourth moments about the point from which the deviations are.
BeamMoments::Plane planeOf(const BeamPiece::Rows<BeamMoments::sizeA>& rows, const double* q,
                           const double* p) {
    std::array<LaneVector, 9> sums{};
    for (std::size_t i = 0; i < rows.size; i += lanes) {
        LaneVector qi, pi, w;
        load(qi, q + i);
        load(pi, p + i);
        load(w, rows.weight.data() + i);
        const LaneVector qq = qi * qi, pp = pi * pi, qp = qi * pi, wqq = w * qq, wpp = w * pp;
        sums[0] += wqq * qi;
        sums[1] += wqq * pi;
        sums[2] += wpp * qi;
        sums[3] += wpp * pi;
        sums[4] += wqq * qq;
        sums[5] += wqq * qp;
        sums[6] += wqq * pp;
        sums[7] += wpp * qp;
        sums[8] += wpp * pp;
    }
    BeamMoments::Plane plane;
    for (std::size_t i = 0; i < 4; ++i) plane.third[i] = sumOf(std::bit_cast<Lanes>(sums[i]));
    for (std::size_t i = 0; i < 5; ++i) plane.fourth[i] = sumOf(std::bit_cast<Lanes>(sums[4 + i]));
    return plane;
}

MOTE_ANY_VECTORS BeamMoments::Sums sumsOf(const BeamPiece& piece, bool timed) {
    BeamMoments::Sums out;
    Centred<BeamMoments::sizeA> a;
    out.a = timed ? secondOf<NothingKnown>(piece.a, a) : secondOf<NoTime>(piece.a, a);
    for (std::size_t i = 0; i < piece.a.count; ++i) {
        out.greatestWeight = std::max(out.greatestWeight, piece.a.weight[i]);
    }
    if (out.a.weight > 0.0) {
        for (std::size_t plane = 0; plane < out.planes.size(); ++plane) {
            const std::size_t q = 2 * plane, p = q + 1;
            const auto about = planeOf(piece.a, a.deviation[q].data(), a.deviation[p].data());
            auto lower = moments::lowerOf(out.a, q, p);
            lower.q = a.rest[q];
            lower.p = a.rest[p];
            out.planes[plane] =
                moments::shifted(about, lower, -a.rest[q] / out.a.weight, -a.rest[p] / out.a.weight);
        }
    }
    if (piece.b.count == piece.a.count) {
        out.b = slopesOf(piece, out.a, a);
    } else {
        Centred<BeamMoments::sizeB> b;
        out.b = secondOf<NothingKnown>(piece.b, b);
    }
    return out;
}

}  // namespace

void BeamMoments::add(const BeamRows& rows) {
    Sums sums;
    sums.block = rows.block;
    const bool timed = !rows.coordinate[3].empty();
    forEachPiece(rows, mass_, true, [&](const BeamPiece& piece) { join(sums, sumsOf(piece, timed)); });
    sums.particles = rows.size;
    sums.known = knownCoordinates(rows);
    blocks_.push_back(sums);
}

BeamMoments::Sums BeamMoments::total() const {
    auto blocks = blocks_;
    std::ranges::sort(blocks, {}, &Sums::block);
    Sums total;
    for (const auto& block : blocks) join(total, block);
    return total;
}

}  // namespace mote::storage
