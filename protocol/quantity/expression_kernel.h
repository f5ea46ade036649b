// SPDX-License-Identifier: GPL-3.0-or-later
//
// The operations of expressions (expression.h), and how each is done for a block of rows.
#pragma once

#include <cstddef>

#include "protocol/quantity/expression.h"

namespace mote {

enum class Expression::Operation : std::uint8_t {
    add,
    subtract,
    multiply,
    divide,
    modulo,
    power,
    less,
    lessEqual,
    greater,
    greaterEqual,
    equal,
    unequal,
    both,
    either,
    least,
    greatest,
    hypot,
    atan2,
    negate,
    notTrue,
    abs,
    sqrt,
    exp,
    log,
    log10,
    sin,
    cos,
    tan,
    asin,
    acos,
    atan,
    sinh,
    cosh,
    tanh,
    floor,
    ceil,
    round,
    sign,
    where,
};

/// What functions (exp, sin, atan2, powers, ...) are made with: SLEEF's vectors, within 1 unit in the last
/// place and of both widths the same bits, or the C library's, within 3, a row at a time.
enum class FunctionVectors : std::uint8_t { none, avx2, avx512 };

/// The widest that this processor has.
FunctionVectors functionVectorsHere();

/// to[i] = operation(a[i], b[i], c[i]) for i < count; `to` may be one of the others. What an operation does
/// not take is not read.
void runOperation(Expression::Operation operation, const double* a, const double* b, const double* c,
                  double* to, std::size_t count, FunctionVectors vectors = functionVectorsHere());

}  // namespace mote
