// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/random.h"

#include <glm/geometric.hpp>

namespace mote::test {
namespace {

/// splitmix64 (Steele, Lea, Flood 2014): full avalanche.
std::uint64_t mixed(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
}

}  // namespace

Random::Random(std::uint64_t seed, std::uint64_t stream)
    : state_(mixed(seed + 0x9e3779b97f4a7c15ULL) ^ mixed(~stream)) {}

std::uint64_t Random::next() {
    state_ += 0x9e3779b97f4a7c15ULL;
    return mixed(state_);
}

glm::dvec3 Random::direction() {
    // In a ball; whole numbers, whose squares are exact.
    while (true) {
        const auto side = [this] { return static_cast<double>(below(2001)) - 1000.0; };
        const double x = side(), y = side(), z = side();
        const glm::dvec3 place(x, y, z);
        const double square = glm::dot(place, place);
        if (square > 0.0 && square <= 1e6) return place / std::sqrt(square);
    }
}

}  // namespace mote::test
