// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/beam/quantity.h"

#include <cmath>

namespace mote::storage {
namespace {

using Columns = std::span<const std::span<const double>>;

/// (x px + y py) / r, and on the axis its limit for a particle that leaves it.
double radialMomentum(double x, double y, double px, double py) {
    const double radius = std::hypot(x, y);
    return radius > 0.0 ? (x * px + y * py) / radius : std::hypot(px, py);
}

double kineticEnergy(double momentum, double mass) {
    // sqrt(p^2 + m^2) - m without the difference of two large numbers.
    return momentum * (momentum / (std::hypot(momentum, mass) + mass));
}

template <class Value>
void fill(std::span<double> out, Value value) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = value(i);
}

}  // namespace

void evaluate(const DerivedQuantity& quantity, Columns c, const BeamContext& context, std::span<double> out) {
    const auto momentum = [&](std::size_t i) { return std::hypot(c[0][i], c[1][i], c[2][i]); };
    using enum DerivedQuantity::Kind;
    switch (quantity.kind) {
        case r:
            return fill(out, [&](std::size_t i) { return std::hypot(c[0][i], c[1][i]); });
        case theta:
            return fill(out, [&](std::size_t i) { return std::atan2(c[1][i], c[0][i]); });
        case xp:
        case yp:
            return fill(out, [&](std::size_t i) { return c[0][i] / c[1][i]; });
        case pr:
            return fill(out,
                        [&](std::size_t i) { return radialMomentum(c[0][i], c[1][i], c[2][i], c[3][i]); });
        case delta:
            return fill(out, [&](std::size_t i) {
                return (momentum(i) - context.meanMomentum) / context.meanMomentum;
            });
        case gamma:
            return fill(out, [&](std::size_t i) { return std::hypot(1.0, momentum(i) / context.mass); });
        case energy:
            return fill(out, [&](std::size_t i) { return kineticEnergy(momentum(i), context.mass); });
        case p:
            return fill(out, momentum);
    }
}

}  // namespace mote::storage
