// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/envelope.h"

#include <algorithm>
#include <cmath>

#include "preprocess/synth/core_field.h"

namespace mote::prep {
namespace {

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
