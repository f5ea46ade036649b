// SPDX-License-Identifier: GPL-3.0-or-later
//
// Ellipses of planes, actions of particles by them, and how much of the weight is a percentage. Pure
// functions; without contraction they give the same bits on every processor.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "storage/beam/beam_statistics.h"
#include "storage/beam/moment_sums.h"

namespace mote::storage {

/// By the second moments of a plane.
inline PlaneFrame planeFrame(const BeamMoments::Sums& total, std::size_t plane) {
    constexpr double noEmittance = 1e-14;
    const auto both = (std::uint32_t{1} << plane) | (std::uint32_t{1} << (plane + 4));
    const auto lower = moments::lowerOf(total.a, 2 * plane, 2 * plane + 1);
    PlaneFrame frame;
    frame.q = total.a.mean[2 * plane];
    frame.p = total.a.mean[2 * plane + 1];
    frame.k = lower.qp / lower.qq;
    const double rest = lower.pp - frame.k * lower.qp;
    frame.a = lower.weight / lower.qq;
    frame.b = lower.weight / rest;
    frame.defined = (total.known & both) == both && lower.qq > 0.0 && rest > noEmittance * lower.pp &&
                    std::isfinite(frame.a) && std::isfinite(frame.b);
    return frame;
}

/// Of a deviation from the means.
template <class Number>
Number actionOf(const PlaneFrame& of, const Number& q, const Number& p) {
    const Number s = p - of.k * q;
    return of.a * q * q + of.b * s * s;
}

/// Whether so much of the weight is the percentage or more.
inline bool reachesPercent(std::uint64_t shares, std::uint32_t percent, std::uint64_t all) {
    const std::uint64_t whole = all / 100, rest = all % 100;
    const std::uint64_t needed = whole * percent + (rest * percent + 99) / 100;
    return shares >= needed;
}

}  // namespace mote::storage
