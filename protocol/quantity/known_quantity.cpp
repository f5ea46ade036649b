// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/quantity/known_quantity.h"

#include <algorithm>
#include <cmath>

namespace mote {
namespace {

using Columns = KnownQuantity::Columns;
using Out = std::span<double>;

template <class Value>
void forEachRow(Out out, Value value) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = value(i);
}

double momentumOf(Columns c, std::size_t i) {
    return std::hypot(c[0][i], c[1][i], c[2][i]);
}

/// (x px + y py) / r, and on the axis its limit for a particle that leaves it.
double radialMomentum(double x, double y, double px, double py) {
    const double radius = std::hypot(x, y);
    return radius > 0.0 ? (x * px + y * py) / radius : std::hypot(px, py);
}

double kineticEnergy(double momentum, const BeamContext& context) {
    if (context.photons) return momentum;
    // sqrt(p^2 + m^2) - m without the difference of two large numbers.
    return momentum * (momentum / (std::hypot(momentum, context.mass) + context.mass));
}

void ratio(Columns c, const BeamContext&, Out out) {
    forEachRow(out, [&](std::size_t i) { return c[0][i] / c[1][i]; });
}

/// Coordinate `at` in the bunch's own frame.
template <std::size_t at>
void fromMean(Columns c, const BeamContext& context, Out out) {
    forEachRow(out, [&, mean = context.mean[at]](std::size_t i) { return c[0][i] - mean; });
}

constexpr std::size_t placeOfX = 0, placeOfY = 1, placeOfZ = 2, placeOfT = 3, placeOfPx = 4, placeOfPy = 5,
                      placeOfPz = 6;

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
        {"r",
         "r",
         "m",
         {"x", "y"},
         [](Columns c, const BeamContext&, Out out) {
             forEachRow(out, [&](std::size_t i) { return std::hypot(c[0][i], c[1][i]); });
         }},
        {"theta",
         "\u03b8",
         "rad",
         {"x", "y"},
         [](Columns c, const BeamContext&, Out out) {
             forEachRow(out, [&](std::size_t i) { return std::atan2(c[1][i], c[0][i]); });
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
        {"p", "p", "eV/c", momenta,
         [](Columns c, const BeamContext&, Out out) {
             forEachRow(out, [&](std::size_t i) { return momentumOf(c, i); });
         }},
        {"delta", "\u03b4", "1", momenta,
         [](Columns c, const BeamContext& context, Out out) {
             const double mean = context.meanMomentum;
             forEachRow(out, [&](std::size_t i) { return (momentumOf(c, i) - mean) / mean; });
         },
         meanMomentum},
        {"gamma", "\u03b3", "1", momenta,
         [](Columns c, const BeamContext& context, Out out) {
             forEachRow(out, [&](std::size_t i) { return std::hypot(1.0, momentumOf(c, i) / context.mass); });
         },
         mass},
        {"energy", "E_kin", "eV", momenta,
         [](Columns c, const BeamContext& context, Out out) {
             forEachRow(out, [&](std::size_t i) { return kineticEnergy(momentumOf(c, i), context); });
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
