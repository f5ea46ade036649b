// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/quantity/known_quantity.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "protocol/quantity/any_vectors.h"
#include "protocol/quantity/expression_kernel.h"

namespace mote {
namespace {

using Columns = KnownQuantity::Columns;
using Out = std::span<double>;

template <class Value>
inline void forEachRow(Out out, Value value) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = value(i);
}

/// Whether a sum of squares has lost nothing at a double's ends.
inline bool isWithin(double square) {
    return square > 1e-280 && square < 1e280;
}

/// The rows' sums of squares; whether all are within.
MOTE_ANY_VECTORS bool squaresOf(Columns c, Out out) {
    int beyond = 0;
    const double *const x = c[0].data(), *const y = c[1].data();
    const double* const z = c.size() > 2 ? c[2].data() : nullptr;
    for (std::size_t i = 0; i < out.size(); ++i) {
        const double square = x[i] * x[i] + y[i] * y[i] + (z != nullptr ? z[i] * z[i] : 0.0);
        out[i] = square;
        beyond |= static_cast<int>(!isWithin(square));
    }
    return beyond == 0;
}
MOTE_ANY_VECTORS void rootsOf(Out out) {
    forEachRow(out, [&](std::size_t i) { return std::sqrt(out[i]); });
}

/// sqrt(a^2 + b^2) or of three, as std::hypot has it where squares are too great or too small.
void lengthsOf(Columns c, Out out) {
    if (squaresOf(c, out)) return rootsOf(out);
    forEachRow(out, [&](std::size_t i) {
        if (isWithin(out[i])) return std::sqrt(out[i]);
        return c.size() > 2 ? std::hypot(c[0][i], c[1][i], c[2][i]) : std::hypot(c[0][i], c[1][i]);
    });
}

/// (x px + y py) / r, and on the axis its limit for a particle that leaves it.
double radialMomentum(double x, double y, double px, double py) {
    const double radius = std::hypot(x, y);
    return radius > 0.0 ? (x * px + y * py) / radius : std::hypot(px, py);
}

/// sqrt(p^2 + m^2); what is greater than any mass is it itself.
inline double totalEnergy(double momentum, double mass) {
    return momentum > 1e140 ? momentum : std::sqrt(momentum * momentum + mass * mass);
}

/// From momenta to sqrt(p^2 + m^2) - m, without the difference of two large numbers.
MOTE_ANY_VECTORS void makeKinetic(double m, Out out) {
    forEachRow(out, [&](std::size_t i) { return out[i] * (out[i] / (totalEnergy(out[i], m) + m)); });
}
MOTE_ANY_VECTORS void makeGamma(double mass, Out out) {
    forEachRow(out, [&](std::size_t i) { return totalEnergy(out[i] / mass, 1.0); });
}
/// The same by each particle's own mass; of those without mass the kinetic energy is the momentum, and there
/// is no gamma.
MOTE_ANY_VECTORS void makeKinetics(const double* m, Out out) {
    forEachRow(out, [&](std::size_t i) {
        return m[i] > 0.0 ? out[i] * (out[i] / (totalEnergy(out[i], m[i]) + m[i])) : out[i];
    });
}
MOTE_ANY_VECTORS void makeGammas(const double* m, Out out) {
    forEachRow(out, [&](std::size_t i) {
        return m[i] > 0.0 ? totalEnergy(out[i] / m[i], 1.0) : std::numeric_limits<double>::quiet_NaN();
    });
}
MOTE_ANY_VECTORS void makeDelta(double mean, Out out) {
    forEachRow(out, [&](std::size_t i) { return (out[i] - mean) / mean; });
}

MOTE_ANY_VECTORS void ratio(Columns c, const BeamContext&, Out out) {
    forEachRow(out, [&](std::size_t i) { return c[0][i] / c[1][i]; });
}

/// Coordinate `at` in the bunch's own frame.
template <std::size_t at>
void fromMean(Columns c, const BeamContext& context, Out out) {
    forEachRow(out, [&, mean = context.mean[at]](std::size_t i) { return c[0][i] - mean; });
}

constexpr std::size_t placeOfX = 0, placeOfY = 1, placeOfZ = 2, placeOfT = 3, placeOfPx = 4, placeOfPy = 5,
                      placeOfPz = 6;
constexpr std::size_t placeOfMass = 3;  // behind the momenta

std::vector<KnownQuantity> makeTable() {
    using enum KnownQuantity::Need;
    const std::vector<std::string_view> momenta{"px", "py", "pz"};
    return {
        {"x", "x", "m", {"x"}},
        {"y", "y", "m", {"y"}},
        {"z", "z", "m", {"z"}},
        {"t", "t", "s", {"t"}},
        {"px", "p_x", "eV/c", {"px"}},
        {"py", "p_y", "eV/c", {"py"}},
        {"pz", "p_z", "eV/c", {"pz"}},
        {"weight", "w", "1", {"weight"}},
        {"r", "r", "m", {"x", "y"}, [](Columns c, const BeamContext&, Out out) { lengthsOf(c, out); }},
        {"theta",
         "\u03b8",
         "rad",
         {"x", "y"},
         [](Columns c, const BeamContext&, Out out) {
             runOperation(Expression::Operation::atan2, c[1].data(), c[0].data(), nullptr, out.data(),
                          out.size());
         }},
        {"xp", "x\u2032", "rad", {"px", "pz"}, ratio},
        {"yp", "y\u2032", "rad", {"py", "pz"}, ratio},
        {"pr",
         "p_r",
         "eV/c",
         {"x", "y", "px", "py"},
         [](Columns c, const BeamContext&, Out out) {
             forEachRow(out,
                        [&](std::size_t i) { return radialMomentum(c[0][i], c[1][i], c[2][i], c[3][i]); });
         }},
        {"p", "p", "eV/c", momenta, [](Columns c, const BeamContext&, Out out) { lengthsOf(c, out); }},
        {"delta", "\u03b4", "1", momenta,
         [](Columns c, const BeamContext& context, Out out) {
             lengthsOf(c, out);
             makeDelta(context.meanMomentum, out);
         },
         meanMomentum},
        {"gamma", "\u03b3", "1", momenta,
         [](Columns c, const BeamContext& context, Out out) {
             lengthsOf(c, out);
             if (c.size() > placeOfMass) return makeGammas(c[placeOfMass].data(), out);
             makeGamma(context.mass, out);
         },
         mass},
        {"energy", "E_kin", "eV", momenta,
         [](Columns c, const BeamContext& context, Out out) {
             lengthsOf(c, out);
             if (c.size() > placeOfMass) return makeKinetics(c[placeOfMass].data(), out);
             if (!context.photons) makeKinetic(context.mass, out);
         },
         massOrPhotons},
        {"zeta", "\u03b6", "m", {"z"}, fromMean<placeOfZ>, means},
        {"tau", "\u03c4", "s", {"t"}, fromMean<placeOfT>, means},
        {"x_c", "x_c", "m", {"x"}, fromMean<placeOfX>, means},
        {"y_c", "y_c", "m", {"y"}, fromMean<placeOfY>, means},
        {"px_c", "p_x,c", "eV/c", {"px"}, fromMean<placeOfPx>, means},
        {"py_c", "p_y,c", "eV/c", {"py"}, fromMean<placeOfPy>, means},
        {"pz_c", "p_z,c", "eV/c", {"pz"}, fromMean<placeOfPz>, means},
    };
}

}  // namespace

std::span<const KnownQuantity> knownQuantities() {
    static const auto table = makeTable();
    return table;
}

const KnownQuantity* findKnownQuantity(std::string_view name) {
    const auto all = knownQuantities();
    const auto found = std::ranges::find(all, name, &KnownQuantity::name);
    return found == all.end() ? nullptr : &*found;
}

}  // namespace mote
