// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/quantity/expression_kernel.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

#include <algorithm>
#include <array>
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
    const auto square = [&](std::size_t i) { return a[i] * a[i] + b[i] * b[i]; };
    const auto isOdd = [&](std::size_t i) {
        return static_cast<int>(!(square(i) > small * small)) |
               static_cast<int>(!(square(i) < great * great));
    };
    int odd = 0;
    for (std::size_t i = 0; i < count; ++i) odd |= isOdd(i);
    if (odd == 0) return each(to, count, [&](std::size_t i) { return std::sqrt(square(i)); });
    each(to, count, [&](std::size_t i) { return isOdd(i) ? std::hypot(a[i], b[i]) : std::sqrt(square(i)); });
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
        case Op::floor:
            return all([&](std::size_t i) { return std::floor(a[i]); });
        case Op::ceil:
            return all([&](std::size_t i) { return std::ceil(a[i]); });
        case Op::round:  // halves to the even one, as numpy
            return all([&](std::size_t i) { return std::nearbyint(a[i]); });
        case Op::sign:
            return all([&](std::size_t i) { return a[i] > 0.0 ? 1.0 : a[i] < 0.0 ? -1.0 : a[i]; });
        default:
            return all([&](std::size_t i) { return a[i] != 0.0 ? b[i] : c[i]; });
    }
}

double plainly(Op operation, double a, double b) {
    switch (operation) {
        case Op::exp:
            return std::exp(a);
        case Op::log:
            return std::log(a);
        case Op::log10:
            return std::log10(a);
        case Op::sin:
            return std::sin(a);
        case Op::cos:
            return std::cos(a);
        case Op::tan:
            return std::tan(a);
        case Op::asin:
            return std::asin(a);
        case Op::acos:
            return std::acos(a);
        case Op::atan:
            return std::atan(a);
        case Op::sinh:
            return std::sinh(a);
        case Op::cosh:
            return std::cosh(a);
        case Op::tanh:
            return std::tanh(a);
        case Op::power:
            return std::pow(a, b);
        case Op::atan2:
            return std::atan2(a, b);
        default:
            return moduloOf(a, b);
    }
}

constexpr std::size_t widest = 8;

/// For a count that is a multiple of `widest`; `to` may be one of the others.
using Wide = void (*)(const double* a, const double* b, double* to, std::size_t count);

/// An operation in vectors of 256 and 512 bits; null where they have none.
struct WideFunction {
    Op operation;
    Wide avx2 = nullptr, avx512 = nullptr;
};

#ifdef MOTE_WITH_SLEEF
}  // namespace

// SLEEF's functions within 1 unit in the last place, those of one result for all processors with fused
// products. Its header declares those of one kind of vectors alone, which a source is compiled for.
#define MOTE_DECLARE(function, values4, values8)                                                  \
    extern "C" __attribute__((target("avx2"))) __m256d Sleef_finz_##function##d4_u10avx2 values4; \
    extern "C" __attribute__((target("avx512f"))) __m512d Sleef_finz_##function##d8_u10avx512f values8;
#define MOTE_OF_ONE(function)                                                                              \
    MOTE_DECLARE(function, (__m256d), (__m512d))                                                           \
    __attribute__((target("avx2"))) static void function##4(const double* a, const double*, double* to,    \
                                                            std::size_t count) {                           \
        for (std::size_t i = 0; i < count; i += 4)                                                         \
            _mm256_storeu_pd(to + i, Sleef_finz_##function##d4_u10avx2(_mm256_loadu_pd(a + i)));           \
    }                                                                                                      \
    __attribute__((target("avx512f"))) static void function##8(const double* a, const double*, double* to, \
                                                               std::size_t count) {                        \
        for (std::size_t i = 0; i < count; i += 8)                                                         \
            _mm512_storeu_pd(to + i, Sleef_finz_##function##d8_u10avx512f(_mm512_loadu_pd(a + i)));        \
    }
#define MOTE_OF_TWO(function)                                                                                \
    MOTE_DECLARE(function, (__m256d, __m256d), (__m512d, __m512d))                                           \
    __attribute__((target("avx2"))) static void function##4(const double* a, const double* b, double* to,    \
                                                            std::size_t count) {                             \
        for (std::size_t i = 0; i < count; i += 4)                                                           \
            _mm256_storeu_pd(                                                                                \
                to + i, Sleef_finz_##function##d4_u10avx2(_mm256_loadu_pd(a + i), _mm256_loadu_pd(b + i)));  \
    }                                                                                                        \
    __attribute__((target("avx512f"))) static void function##8(const double* a, const double* b, double* to, \
                                                               std::size_t count) {                          \
        for (std::size_t i = 0; i < count; i += 8)                                                           \
            _mm512_storeu_pd(to + i, Sleef_finz_##function##d8_u10avx512f(_mm512_loadu_pd(a + i),            \
                                                                          _mm512_loadu_pd(b + i)));          \
    }
MOTE_OF_ONE(exp)
MOTE_OF_ONE(log)
MOTE_OF_ONE(log10)
MOTE_OF_ONE(sin)
MOTE_OF_ONE(cos)
MOTE_OF_ONE(tan)
MOTE_OF_ONE(asin)
MOTE_OF_ONE(acos)
MOTE_OF_ONE(atan)
MOTE_OF_ONE(sinh)
MOTE_OF_ONE(cosh)
MOTE_OF_ONE(tanh)
MOTE_OF_TWO(pow)
MOTE_OF_TWO(atan2)
#undef MOTE_DECLARE
#undef MOTE_OF_ONE
#undef MOTE_OF_TWO

namespace {
constexpr std::array wideFunctions{
    WideFunction{Op::exp, exp4, exp8},         WideFunction{Op::log, log4, log8},
    WideFunction{Op::log10, log104, log108},   WideFunction{Op::sin, sin4, sin8},
    WideFunction{Op::cos, cos4, cos8},         WideFunction{Op::tan, tan4, tan8},
    WideFunction{Op::asin, asin4, asin8},      WideFunction{Op::acos, acos4, acos8},
    WideFunction{Op::atan, atan4, atan8},      WideFunction{Op::sinh, sinh4, sinh8},
    WideFunction{Op::cosh, cosh4, cosh8},      WideFunction{Op::tanh, tanh4, tanh8},
    WideFunction{Op::power, pow4, pow8},       WideFunction{Op::atan2, atan24, atan28},
    WideFunction{Op::modulo, nullptr, nullptr}};
#else
constexpr std::array wideFunctions{
    WideFunction{Op::exp},   WideFunction{Op::log},   WideFunction{Op::log10}, WideFunction{Op::sin},
    WideFunction{Op::cos},   WideFunction{Op::tan},   WideFunction{Op::asin},  WideFunction{Op::acos},
    WideFunction{Op::atan},  WideFunction{Op::sinh},  WideFunction{Op::cosh},  WideFunction{Op::tanh},
    WideFunction{Op::power}, WideFunction{Op::atan2}, WideFunction{Op::modulo}};
#endif

/// SLEEF's end a little before the largest double: what they take for infinite, or for no number, the C
/// library says.
constexpr bool endsEarly(Op operation) {
    return operation == Op::sinh || operation == Op::cosh || operation == Op::power;
}

/// Any rows; a row's value is the same among any others.
void runWide(Wide wide, Op operation, const double* a, const double* b, double* to, std::size_t count) {
    constexpr std::size_t together = 256;
    const bool checked = endsEarly(operation);
    const bool two = operation == Op::power || operation == Op::atan2;
    const auto whole = checked ? 0 : count / widest * widest;
    wide(a, b, to, whole);
    std::array<double, together> first{}, second{}, made{};
    for (std::size_t begin = whole; begin < count; begin += together) {
        const auto rows = std::min(together, count - begin);
        std::copy_n(a + begin, rows, first.begin());
        if (two) std::copy_n(b + begin, rows, second.begin());
        wide(first.data(), second.data(), made.data(), (rows + widest - 1) / widest * widest);
        for (std::size_t i = 0; checked && i < rows; ++i) {
            if (!std::isfinite(made[i])) made[i] = plainly(operation, first[i], second[i]);
        }
        std::copy_n(made.begin(), rows, to + begin);
    }
}

}  // namespace

FunctionVectors functionVectorsHere() {
#ifdef MOTE_WITH_SLEEF
    static const auto here = !__builtin_cpu_supports("fma")      ? FunctionVectors::none
                             : __builtin_cpu_supports("avx512f") ? FunctionVectors::avx512
                             : __builtin_cpu_supports("avx2")    ? FunctionVectors::avx2
                                                                 : FunctionVectors::none;
    return here;
#else
    return FunctionVectors::none;
#endif
}

void runOperation(Op operation, const double* a, const double* b, const double* c, double* to,
                  std::size_t count, FunctionVectors vectors) {
    const auto* const found = std::ranges::find(wideFunctions, operation, &WideFunction::operation);
    if (found == wideFunctions.end()) return runQuick(operation, a, b, c, to, count);
    const auto wide = vectors == FunctionVectors::avx512 ? found->avx512
                      : vectors == FunctionVectors::avx2 ? found->avx2
                                                         : nullptr;
    if (wide != nullptr) return runWide(wide, operation, a, b, to, count);
    const bool two = operation == Op::power || operation == Op::atan2 || operation == Op::modulo;
    for (std::size_t i = 0; i < count; ++i) to[i] = plainly(operation, a[i], two ? b[i] : 0.0);
}

}  // namespace mote
