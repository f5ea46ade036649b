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

/// The weighted sums of the products of deviation `a` and those from it on, in one pass: a sum that waits for
/// nothing but itself leaves most of a core idle. Unrolled, all sums stay in registers.
template <std::size_t a, std::size_t N, class Sums>
void addProductsOf(const BeamPiece::Rows<N>& rows, const Centred<N>& centred, Sums& to) {
    std::array<LaneVector, N - a> sums{};
    for (std::size_t i = 0; i < rows.size; i += lanes) {
        LaneVector weighted, deviation;
        load(weighted, rows.weight.data() + i);
        load(deviation, centred.deviation[a].data() + i);
        weighted *= deviation;
#pragma GCC unroll 16
        for (std::size_t b = a; b < N; ++b) {
            load(deviation, centred.deviation[b].data() + i);
            sums[b - a] += weighted * deviation;
        }
    }
    for (std::size_t b = a; b < N; ++b) to[pairIndex<N>(a, b)] = sumOf(std::bit_cast<Lanes>(sums[b - a]));
}

template <std::size_t N, class Sums, std::size_t... a>
void addProducts(const BeamPiece::Rows<N>& rows, const Centred<N>& centred, Sums& to,
                 std::index_sequence<a...> /*variables*/) {
    (addProductsOf<a>(rows, centred, to), ...);
}

template <std::size_t N>
BeamMoments::Second<N> secondOf(const BeamPiece::Rows<N>& rows, Centred<N>& centred) {
    BeamMoments::Second<N> out;
    out.count = rows.count;
    if (rows.count == 0) return out;
    out.weight = laneSum(rows.size, [&](std::size_t i) { return rows.weight[i]; });
    for (std::size_t a = 0; a < N; ++a) {
        const auto& value = rows.value[a];
        Lanes least, greatest;
        least.fill(value[0]);
        greatest.fill(value[0]);
        for (std::size_t i = 0; i < rows.size; i += lanes) {  // beyond the end lie copies of the first
            for (std::size_t k = 0; k < lanes; ++k) {
                least[k] = value[i + k] < least[k] ? value[i + k] : least[k];
                greatest[k] = value[i + k] > greatest[k] ? value[i + k] : greatest[k];
            }
        }
        out.least[a] = *std::ranges::min_element(least);
        out.greatest[a] = *std::ranges::max_element(greatest);
    }
    if (out.weight == 0.0) return out;
    for (std::size_t a = 0; a < N; ++a) {
        const auto& value = rows.value[a];
        const double mean =
            laneSum(rows.size, [&](std::size_t i) { return rows.weight[i] * value[i]; }) / out.weight;
        auto& deviation = centred.deviation[a];
        for (std::size_t i = 0; i < rows.size; ++i) deviation[i] = value[i] - mean;
        centred.rest[a] = laneSum(rows.size, [&](std::size_t i) { return rows.weight[i] * deviation[i]; });
        out.mean[a] = mean + centred.rest[a] / out.weight;
    }
    addProducts<N>(rows, centred, out.sum, std::make_index_sequence<N>());
    for (std::size_t a = 0; a < N; ++a) {
        for (std::size_t b = a; b < N; ++b)
            out.sum[pairIndex<N>(a, b)] -= centred.rest[a] * (centred.rest[b] / out.weight);
    }
    return out;
}

/// Third and fourth moments about the point from which the deviations are.
BeamMoments::Plane planeOf(const BeamPiece::Rows<BeamMoments::sizeA>& rows, const double* q,
                           const double* p) {
    std::array<Lanes, 9> sums{};
    for (std::size_t i = 0; i < rows.size; i += lanes) {
        for (std::size_t k = 0; k < lanes; ++k) {
            const double qi = q[i + k], pi = p[i + k], w = rows.weight[i + k];
            const double qq = qi * qi, pp = pi * pi, qp = qi * pi;
            const double wqq = w * qq, wpp = w * pp;
            sums[0][k] += wqq * qi;
            sums[1][k] += wqq * pi;
            sums[2][k] += wpp * qi;
            sums[3][k] += wpp * pi;
            sums[4][k] += wqq * qq;
            sums[5][k] += wqq * qp;
            sums[6][k] += wqq * pp;
            sums[7][k] += wpp * qp;
            sums[8][k] += wpp * pp;
        }
    }
    BeamMoments::Plane plane;
    for (std::size_t i = 0; i < 4; ++i) plane.third[i] = sumOf(sums[i]);
    for (std::size_t i = 0; i < 5; ++i) plane.fourth[i] = sumOf(sums[4 + i]);
    return plane;
}

MOTE_ANY_VECTORS BeamMoments::Sums sumsOf(const BeamPiece& piece) {
    BeamMoments::Sums out;
    Centred<BeamMoments::sizeA> a;
    out.a = secondOf(piece.a, a);
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
    Centred<BeamMoments::sizeB> b;
    out.b = secondOf(piece.b, b);
    return out;
}

}  // namespace

void BeamMoments::add(const BeamRows& rows) {
    Sums sums;
    sums.block = rows.block;
    forEachPiece(rows, mass_, true, [&](const BeamPiece& piece) { join(sums, sumsOf(piece)); });
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
