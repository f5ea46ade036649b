// SPDX-License-Identifier: GPL-3.0-or-later
//
// Sums of moments of pieces and how two of them become one: weighted second moments of N variables, and the
// third and fourth ones of a coordinate and its momentum, all about the means. Pure functions.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "storage/beam/beam_statistics.h"

namespace mote::storage::moments {

template <std::size_t N>
using Second = BeamMoments::Second<N>;
using Plane = BeamMoments::Plane;

/// Where the sum of variables a <= b lies.
template <std::size_t N>
constexpr std::size_t pairIndex(std::size_t a, std::size_t b) {
    return a * N - a * (a + 1) / 2 + b;
}

/// Moments of a coordinate and its momentum up to the second order, about some point.
struct Lower {
    double weight = 0.0, q = 0.0, p = 0.0, qq = 0.0, qp = 0.0, pp = 0.0;
};

/// The third and fourth moments about a point that lies (-dq, -dp) from that of `plane` and `lower`.
Plane shifted(const Plane& plane, const Lower& lower, double dq, double dp);

template <std::size_t N>
Lower lowerOf(const Second<N>& second, std::size_t q, std::size_t p) {
    return {second.weight,
            0.0,
            0.0,
            second.sum[pairIndex<N>(q, q)],
            second.sum[pairIndex<N>(q, p)],
            second.sum[pairIndex<N>(p, p)]};
}

/// Adds what lies about other means.
template <std::size_t N>
void join(Second<N>& to, const Second<N>& from) {
    if (from.count == 0) return;
    if (to.count == 0 || to.weight == 0.0) {
        const auto before = to;
        to = from;
        to.count += before.count;
        if (before.count == 0) return;
        for (std::size_t a = 0; a < N; ++a) {
            to.least[a] = std::min(to.least[a], before.least[a]);
            to.greatest[a] = std::max(to.greatest[a], before.greatest[a]);
        }
        return;
    }
    const double weight = to.weight + from.weight;
    const double share = from.weight / weight;
    std::array<double, N> apart{};
    for (std::size_t a = 0; a < N; ++a) apart[a] = from.mean[a] - to.mean[a];
    for (std::size_t a = 0; a < N; ++a) {
        for (std::size_t b = a; b < N; ++b) {
            const auto i = pairIndex<N>(a, b);
            to.sum[i] += from.sum[i] + apart[a] * apart[b] * (to.weight * share);
        }
        to.mean[a] += apart[a] * share;
        to.least[a] = std::min(to.least[a], from.least[a]);
        to.greatest[a] = std::max(to.greatest[a], from.greatest[a]);
    }
    to.weight = weight;
    to.count += from.count;
}

/// Adds all of a piece or block.
void join(BeamMoments::Sums& to, const BeamMoments::Sums& from);

}  // namespace mote::storage::moments
