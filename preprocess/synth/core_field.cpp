// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/core_field.h"

#include <algorithm>
#include <cmath>

namespace mote::prep {
namespace {

constexpr std::size_t terms = CoreKick::terms;
using Series = std::array<double, terms>;

/// cos(pi (2k + 1) / (2 terms)) for 12 terms, by turning in steps of 15 degrees: no mathematical library but
/// sqrt, so that a seed gives the same bytes everywhere.
Series chebyshevNodes() {
    static_assert(terms == 12);
    const double stepCosine = (std::sqrt(6.0) + std::sqrt(2.0)) / 4.0;
    const double stepSine = (std::sqrt(6.0) - std::sqrt(2.0)) / 4.0;
    double cosine = std::sqrt(0.5 * (1.0 + stepCosine));
    double sine = std::sqrt(0.5 * (1.0 - stepCosine));
    Series nodes{};
    for (double& node : nodes) {
        node = cosine;
        const double turned = cosine * stepCosine - sine * stepSine;
        sine = sine * stepCosine + cosine * stepSine;
        cosine = turned;
    }
    return nodes;
}

/// T_0 .. T_{terms-1} at x.
Series chebyshevValues(double x) {
    Series values{};
    values[0] = 1.0;
    values[1] = x;
    for (std::size_t n = 2; n < terms; ++n) values[n] = 2.0 * x * values[n - 1] - values[n - 2];
    return values;
}

/// Ascending powers of the polynomial that takes `values` at the nodes.
Series interpolate(const Series& nodes, const Series& values) {
    Series result{};
    Series earlier{}, current{};  // powers of T_{n-1} and T_n
    current[0] = 1.0;
    for (std::size_t n = 0; n < terms; ++n) {
        double weight = 0.0;
        for (std::size_t k = 0; k < terms; ++k) weight += values[k] * chebyshevValues(nodes[k])[n];
        weight *= (n == 0 ? 1.0 : 2.0) / static_cast<double>(terms);
        for (std::size_t i = 0; i < terms; ++i) result[i] += weight * current[i];
        Series next{};
        for (std::size_t i = 1; i < terms; ++i) next[i] = (n == 0 ? 1.0 : 2.0) * current[i - 1] - earlier[i];
        next[0] = -earlier[0];
        earlier = current;
        current = next;
    }
    return result;
}

}  // namespace

double carlsonRd(double x, double y, double z) {
    // Carlson, Numerical Algorithms 10 (1995) 13: duplicate until the arguments agree, then a Taylor series.
    double sum = 0.0, power = 1.0;
    for (int i = 0; i < 60; ++i) {
        const double mean = 0.2 * (x + y + 3.0 * z);
        const double spread = std::max({std::abs(mean - x), std::abs(mean - y), std::abs(mean - z)});
        if (spread < 1.5e-3 * mean) break;  // the series' error is of the order of the sixth power
        const double sx = std::sqrt(x), sy = std::sqrt(y), sz = std::sqrt(z);
        const double lambda = sx * sy + sx * sz + sy * sz;
        sum += power / (sz * (z + lambda));
        power *= 0.25;
        x = 0.25 * (x + lambda);
        y = 0.25 * (y + lambda);
        z = 0.25 * (z + lambda);
    }
    const double mean = 0.2 * (x + y + 3.0 * z);
    const double dx = (mean - x) / mean, dy = (mean - y) / mean, dz = -(dx + dy) / 3.0;
    const double e2 = dx * dy - 6.0 * dz * dz;
    const double e3 = (3.0 * dx * dy - 8.0 * dz * dz) * dz;
    const double e4 = 3.0 * (dx * dy - dz * dz) * dz * dz;
    const double e5 = dx * dy * dz * dz * dz;
    const double series = 1.0 - 3.0 * e2 / 14.0 + e3 / 6.0 + 9.0 * e2 * e2 / 88.0 - 3.0 * e4 / 22.0 -
                          9.0 * e2 * e3 / 52.0 + 3.0 * e5 / 26.0;
    return 3.0 * sum + power * series / (mean * std::sqrt(mean));
}

std::array<double, 3> ellipsoidForm(const std::array<double, 3>& squares) {
    const auto& [x, y, z] = squares;
    return {carlsonRd(y, z, x), carlsonRd(z, x, y), carlsonRd(x, y, z)};
}

double confocalCoordinate(const std::array<double, 3>& squares, const std::array<double, 3>& point) {
    double lambda = 0.0;
    for (int i = 0; i < 100; ++i) {
        double sum = 0.0, slope = 0.0;
        for (std::size_t plane = 0; plane < 3; ++plane) {
            const double part = point[plane] / (squares[plane] + lambda);
            sum += point[plane] * part;
            slope += part * part;
        }
        if (sum <= 1.0) break;
        // Newton on 1/sum, which is nearly linear in lambda and concave: every step stays left of the root.
        const double next = lambda + sum * (sum - 1.0) / slope;
        if (!(next > lambda)) break;
        lambda = next;
    }
    return lambda;
}

std::array<double, 3> ellipsoidField(const std::array<double, 3>& squares,
                                     const std::array<double, 3>& point) {
    const double lambda = confocalCoordinate(squares, point);
    const auto form = ellipsoidForm({squares[0] + lambda, squares[1] + lambda, squares[2] + lambda});
    return {point[0] * form[0], point[1] * form[1], point[2] * form[2]};
}

CoreKick coreKick(const std::array<double, 3>& axes, double strength) {
    CoreKick kick;
    for (std::size_t plane = 0; plane < 3; ++plane) kick.squares[plane] = axes[plane] * axes[plane];
    const auto [least, most] = std::minmax_element(axes.begin(), axes.end());
    kick.largest = *most * *most;
    kick.least = *least * *least;
    for (std::size_t plane = 0; plane < 3; ++plane) kick.leastOver[plane] = kick.least / kick.squares[plane];
    // This scale puts the cut's two ends at equal distances from [0, 1], where the polynomial converges
    // fastest.
    kick.scale = *least * *most;
    const Series nodes = chebyshevNodes();
    std::array<Series, 3> values{};
    for (std::size_t k = 0; k < terms; ++k) {
        const double t = 0.5 * (nodes[k] + 1.0);
        std::array<double, 3> scaled{};
        for (std::size_t plane = 0; plane < 3; ++plane) {
            scaled[plane] = 1.0 + (kick.squares[plane] / kick.scale - 1.0) * t;
        }
        const auto form = ellipsoidForm(scaled);
        for (std::size_t plane = 0; plane < 3; ++plane) values[plane][k] = form[plane];
    }
    const double unit = strength / (kick.scale * std::sqrt(kick.scale));
    for (std::size_t plane = 0; plane < 3; ++plane) {
        kick.coefficients[plane] = interpolate(nodes, values[plane]);
        for (double& coefficient : kick.coefficients[plane]) coefficient *= unit;
    }
    return kick;
}

}  // namespace mote::prep
