// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/quantity/expression_kernel.h"

#include <cmath>

#include "protocol/quantity/any_vectors.h"

namespace mote {
namespace {

using Op = Expression::Operation;

template <class Value>
inline void each(double* to, std::size_t count, Value value) {
    for (std::size_t i = 0; i < count; ++i) to[i] = value(i);
}

/// As numpy.mod: with the sign of the divisor.
double moduloOf(double a, double b) {
    const double rest = std::fmod(a, b);
    return rest != 0.0 && (rest < 0.0) != (b < 0.0) ? rest + b : rest;
}

/// sqrt(a^2 + b^2), and where a square is too great or too small for it std::hypot.
inline void hypotOf(const double* a, const double* b, double* to, std::size_t count) {
    constexpr double small = 1e-140, great = 1e140;
    int odd = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const double square = a[i] * a[i] + b[i] * b[i];
        odd |= static_cast<int>(!(square > small * small)) | static_cast<int>(!(square < great * great));
    }
    if (odd == 0) return each(to, count, [&](std::size_t i) { return std::sqrt(a[i] * a[i] + b[i] * b[i]); });
    each(to, count, [&](std::size_t i) { return std::hypot(a[i], b[i]); });
}

inline double truth(bool value) {
    return value ? 1.0 : 0.0;
}

MOTE_ANY_VECTORS void runQuick(Op operation, const double* a, const double* b, const double* c, double* to,
                               std::size_t count) {
    const auto all = [&](auto value) { each(to, count, value); };
    switch (operation) {
        case Op::add:
            return all([&](std::size_t i) { return a[i] + b[i]; });
        case Op::subtract:
            return all([&](std::size_t i) { return a[i] - b[i]; });
        case Op::multiply:
            return all([&](std::size_t i) { return a[i] * b[i]; });
        case Op::divide:
            return all([&](std::size_t i) { return a[i] / b[i]; });
        case Op::less:
            return all([&](std::size_t i) { return truth(a[i] < b[i]); });
        case Op::lessEqual:
            return all([&](std::size_t i) { return truth(a[i] <= b[i]); });
        case Op::greater:
            return all([&](std::size_t i) { return truth(a[i] > b[i]); });
        case Op::greaterEqual:
            return all([&](std::size_t i) { return truth(a[i] >= b[i]); });
        case Op::equal:
            return all([&](std::size_t i) { return truth(a[i] == b[i]); });
        case Op::unequal:
            return all([&](std::size_t i) { return truth(a[i] != b[i]); });
        case Op::both:
            return all([&](std::size_t i) { return a[i] != 0.0 ? truth(b[i] != 0.0) : 0.0; });
        case Op::either:
            return all([&](std::size_t i) { return a[i] != 0.0 ? 1.0 : truth(b[i] != 0.0); });
        case Op::notTrue:
            return all([&](std::size_t i) { return truth(a[i] == 0.0); });
        // What is not a number stays: a + b is none then.
        case Op::least:
            return all([&](std::size_t i) { return a[i] < b[i] ? a[i] : b[i] <= a[i] ? b[i] : a[i] + b[i]; });
        case Op::greatest:
            return all([&](std::size_t i) { return a[i] > b[i] ? a[i] : b[i] >= a[i] ? b[i] : a[i] + b[i]; });
        case Op::hypot:
            return hypotOf(a, b, to, count);
        case Op::negate:
            return all([&](std::size_t i) { return -a[i]; });
        case Op::abs:
            return all([&](std::size_t i) { return std::fabs(a[i]); });
        case Op::sqrt:
            return all([&](std::size_t i) { return std::sqrt(a[i]); });
        case Op::sign:
            return all([&](std::size_t i) { return a[i] > 0.0 ? 1.0 : a[i] < 0.0 ? -1.0 : a[i]; });
        default:
            return all([&](std::size_t i) { return a[i] != 0.0 ? b[i] : c[i]; });
    }
}

/// One function of the library a row.
bool runFunction(Op operation, const double* a, double* to, std::size_t count) {
    using Function = double (*)(double);
    const auto all = [&](Function function) {
        for (std::size_t i = 0; i < count; ++i) to[i] = function(a[i]);
        return true;
    };
    switch (operation) {
        case Op::exp:
            return all(std::exp);
        case Op::log:
            return all(std::log);
        case Op::log10:
            return all(std::log10);
        case Op::sin:
            return all(std::sin);
        case Op::cos:
            return all(std::cos);
        case Op::tan:
            return all(std::tan);
        case Op::asin:
            return all(std::asin);
        case Op::acos:
            return all(std::acos);
        case Op::atan:
            return all(std::atan);
        case Op::sinh:
            return all(std::sinh);
        case Op::cosh:
            return all(std::cosh);
        case Op::tanh:
            return all(std::tanh);
        case Op::floor:
            return all(std::floor);
        case Op::ceil:
            return all(std::ceil);
        case Op::round:
            return all(std::nearbyint);  // halves to the even one, as numpy
        default:
            return false;
    }
}

}  // namespace

void runOperation(Op operation, const double* a, const double* b, const double* c, double* to,
                  std::size_t count) {
    if (runFunction(operation, a, to, count)) return;
    switch (operation) {
        case Op::modulo:
            return each(to, count, [&](std::size_t i) { return moduloOf(a[i], b[i]); });
        case Op::power:
            return each(to, count, [&](std::size_t i) { return std::pow(a[i], b[i]); });
        case Op::atan2:
            return each(to, count, [&](std::size_t i) { return std::atan2(a[i], b[i]); });
        default:
            return runQuick(operation, a, b, c, to, count);
    }
}

}  // namespace mote
