// SPDX-License-Identifier: GPL-3.0-or-later
//
// HalfFloat: the 16 bits of an IEEE 754 binary16, as files hold it. A value, free of threads.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

namespace mote::prep {

struct HalfFloat {
    std::uint16_t bits = 0;

    /// Exact: each is a float.
    float value() const {
        const int exponent = (bits >> 10U) & 31;
        const auto fraction = static_cast<float>(bits & 1023U);
        const float sign = (bits & 0x8000U) != 0 ? -1.0F : 1.0F;
        if (exponent == 31)
            return fraction == 0.0F ? sign * INFINITY : std::numeric_limits<float>::quiet_NaN();
        if (exponent == 0) return sign * std::ldexp(fraction, -24);
        return sign * std::ldexp(fraction + 1024.0F, exponent - 25);
    }
    explicit operator float() const { return value(); }
    explicit operator double() const { return static_cast<double>(value()); }
};

}  // namespace mote::prep
