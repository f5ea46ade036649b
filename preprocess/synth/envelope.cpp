// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/envelope.h"

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

using State = std::array<double, 6>;  ///< three semi-axes, three slopes

State flat(const Envelope& e) {
    return {e.axes[0], e.axes[1], e.axes[2], e.slopes[0], e.slopes[1], e.slopes[2]};
}

Envelope shaped(const State& s) {
    return {{s[0], s[1], s[2]}, {s[3], s[4], s[5]}};
}

Envelope plus(const Envelope& envelope, const Envelope& change, double factor) {
    Envelope result = envelope;
    for (std::size_t plane = 0; plane < 3; ++plane) {
        result.axes[plane] += factor * change.axes[plane];
        result.slopes[plane] += factor * change.slopes[plane];
    }
    return result;
}

bool physical(const Envelope& e) {
    return std::all_of(e.axes.begin(), e.axes.end(), [](double a) { return std::isfinite(a) && a > 0.0; }) &&
           std::all_of(e.slopes.begin(), e.slopes.end(), [](double s) { return std::isfinite(s); });
}

/// Solves matrix * x = right by elimination with pivots; false where the matrix is singular.
bool solve(std::array<State, 6> matrix, State right, State& x) {
    for (std::size_t column = 0; column < 6; ++column) {
        std::size_t pivot = column;
        for (std::size_t row = column + 1; row < 6; ++row) {
            if (std::abs(matrix[row][column]) > std::abs(matrix[pivot][column])) pivot = row;
        }
        if (matrix[pivot][column] == 0.0) return false;
        std::swap(matrix[pivot], matrix[column]);
        std::swap(right[pivot], right[column]);
        for (std::size_t row = column + 1; row < 6; ++row) {
            const double factor = matrix[row][column] / matrix[column][column];
            for (std::size_t k = column; k < 6; ++k) matrix[row][k] -= factor * matrix[column][k];
            right[row] -= factor * right[column];
        }
    }
    for (std::size_t row = 6; row-- > 0;) {
        x[row] = right[row];
        for (std::size_t k = row + 1; k < 6; ++k) x[row] -= matrix[row][k] * x[k];
        x[row] /= matrix[row][row];
    }
    return true;
}

double largestMiss(const State& miss, const State& scale) {
    double most = 0.0;
    for (std::size_t i = 0; i < 6; ++i) most = std::max(most, std::abs(miss[i]) / scale[i]);
    return most;
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

EnvelopeModel::EnvelopeModel(const BeamDesign& design) : channel_(design) {
    const BeamKinematics beam = kinematics(design);
    perveance_ = beam.perveance;
    for (std::size_t plane = 0; plane < 3; ++plane) {
        emittance_[plane] = 5.0 * design.emittance[plane] / (beam.beta * beam.gamma);
    }
}

Envelope EnvelopeModel::derivative(const Envelope& e, const std::array<double, 3>& focusing) const {
    Envelope change;
    const auto form = ellipsoidForm({e.axes[0] * e.axes[0], e.axes[1] * e.axes[1], e.axes[2] * e.axes[2]});
    for (std::size_t plane = 0; plane < 3; ++plane) {
        const double a = e.axes[plane];
        change.axes[plane] = e.slopes[plane];
        change.slopes[plane] = (perveance_ * form[plane] - focusing[plane]) * a +
                               emittance_[plane] * emittance_[plane] / (a * a * a);
    }
    return change;
}

Envelope EnvelopeModel::rungeKutta(const Envelope& e, const std::array<double, 3>& focusing, double h) const {
    const Envelope k1 = derivative(e, focusing);
    const Envelope k2 = derivative(plus(e, k1, 0.5 * h), focusing);
    const Envelope k3 = derivative(plus(e, k2, 0.5 * h), focusing);
    const Envelope k4 = derivative(plus(e, k3, h), focusing);
    return plus(plus(plus(plus(e, k1, h / 6.0), k2, h / 3.0), k3, h / 3.0), k4, h / 6.0);
}

Envelope EnvelopeModel::advance(Envelope envelope, double begin, double end, double step) const {
    const double period = channel_.periodLength();
    for (auto p = static_cast<long>(std::floor(begin / period)); p * period < end; ++p) {
        for (const ChannelElement& element : channel_.elements()) {
            const double from = std::max(begin, p * period + element.begin);
            const double to = std::min(end, p * period + element.begin + element.length);
            // A sliver is the rounding of p * period, not a stretch of channel.
            if (to - from <= 1e-12 * period) continue;
            const auto count = static_cast<int>(std::ceil((to - from) / step * (1.0 - 1e-9)));
            for (int i = 0; i < count; ++i) {
                envelope = rungeKutta(envelope, element.focusing, (to - from) / count);
            }
        }
    }
    return envelope;
}

Envelope EnvelopeModel::smoothGuess() const {
    // Smooth approximation with a sphere's field: k a = perveance / a^2 + emittance^2 / a^3, by bisection. k
    // is (2 sin(mu / 2) / period)^2, from the trace of the period's map.
    const double period = channel_.periodLength();
    const ChannelMap map = channel_.map(0.0, period);
    Envelope guess;
    for (std::size_t plane = 0; plane < 3; ++plane) {
        const double smooth = (2.0 - map[plane].uu - map[plane].pp) / (period * period);
        double low = 1e-7, high = 1.0;
        for (int i = 0; i < 80; ++i) {
            const double a = 0.5 * (low + high);
            const double outward = perveance_ / (a * a) + emittance_[plane] * emittance_[plane] / (a * a * a);
            (smooth * a < outward ? low : high) = a;
        }
        guess.axes[plane] = 0.5 * (low + high);
    }
    // x is widest in the middle of its focusing quadrupole, where y is narrowest.
    guess.axes[0] *= 1.3;
    guess.axes[1] *= 0.7;
    return guess;
}

Result<Envelope> EnvelopeModel::matched() const {
    const Error none{ErrorCode::invalidArgument, "", "the channel has no matched beam"};
    State state = flat(smoothGuess());
    State scale = state;
    for (std::size_t plane = 0; plane < 3; ++plane) scale[3 + plane] = scale[plane] / channel_.periodLength();
    const auto missAfterPeriod = [&](const State& s) {
        State miss = flat(advance(shaped(s), 0.0, channel_.periodLength(), defaultStep));
        for (std::size_t i = 0; i < 6; ++i) miss[i] -= s[i];
        return miss;
    };
    State miss = missAfterPeriod(state);
    for (int iteration = 0; iteration < 60; ++iteration) {
        if (largestMiss(miss, scale) < 1e-13) return shaped(state);
        std::array<State, 6> jacobian{};
        for (std::size_t column = 0; column < 6; ++column) {
            State moved = state;
            const double delta = 1e-6 * scale[column];
            moved[column] += delta;
            const State there = missAfterPeriod(moved);
            for (std::size_t row = 0; row < 6; ++row)
                jacobian[row][column] = (there[row] - miss[row]) / delta;
        }
        State newton{};
        if (!solve(jacobian, miss, newton)) return none;
        // Halve the step until it lessens the miss: the first guess may lie outside Newton's basin.
        bool better = false;
        for (double damping = 1.0; damping > 1e-4 && !better; damping *= 0.5) {
            State trial = state;
            for (std::size_t i = 0; i < 6; ++i) trial[i] -= damping * newton[i];
            if (!physical(shaped(trial))) continue;
            const State trialMiss = missAfterPeriod(trial);
            better = largestMiss(trialMiss, scale) < largestMiss(miss, scale);
            if (better) state = trial, miss = trialMiss;
        }
        if (!better) break;  // rounding, or no solution at all
    }
    if (largestMiss(miss, scale) < 1e-11) return shaped(state);
    return none;
}

std::array<double, 3> EnvelopeModel::depressedAdvance(const Envelope& matched) const {
    // The phase of a particle inside is int emittance / a^2 ds; Simpson over the envelope.
    std::array<double, 3> phase{};
    constexpr int panels = 420;
    const double h = channel_.periodLength() / panels;
    Envelope envelope = matched;
    for (int i = 0; i < panels; ++i) {
        const Envelope middle = advance(envelope, i * h, (i + 0.5) * h, 0.5 * h);
        const Envelope next = advance(middle, (i + 0.5) * h, (i + 1) * h, 0.5 * h);
        for (std::size_t plane = 0; plane < 3; ++plane) {
            const auto rate = [&](const Envelope& e) { return 1.0 / (e.axes[plane] * e.axes[plane]); };
            phase[plane] += emittance_[plane] * h / 6.0 * (rate(envelope) + 4.0 * rate(middle) + rate(next));
        }
        envelope = next;
    }
    return phase;
}

}  // namespace mote::prep
