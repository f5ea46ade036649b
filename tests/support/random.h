// SPDX-License-Identifier: GPL-3.0-or-later
//
// Random: numbers for generated views, the same for the same seed on every machine: whole numbers from a
// generator of our own, and fractions of few bits, so that no product of two of them is rounded. A value; one
// thread.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <initializer_list>

namespace mote::test {

class Random {
  public:
    /// Streams of different numbers are unrelated.
    explicit Random(std::uint64_t seed, std::uint64_t stream = 0);

    std::uint64_t next();
    /// 0 to count - 1.
    std::uint64_t below(std::uint64_t count) { return next() % count; }
    /// In [0, 1), a multiple of 2^-20.
    double unit() { return static_cast<double>(next() >> 44) * 0x1p-20; }
    double between(double least, double most) { return least + (most - least) * unit(); }
    bool chance(double share) { return unit() < share; }
    /// From 2^low up to 2^high, any power of two as likely as another.
    double magnitude(int low, int high) {
        const auto power = low + static_cast<int>(below(static_cast<std::uint64_t>(high - low)));
        return std::ldexp(1.0 + unit(), power);
    }
    double sign() { return chance(0.5) ? 1.0 : -1.0; }
    template <class T>
    T oneOf(std::initializer_list<T> all) {
        return all.begin()[below(all.size())];
    }
    /// Unit, any as likely as another.
    glm::dvec3 direction();

  private:
    std::uint64_t state_;
};

}  // namespace mote::test
