// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/beams.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <numbers>
#include <random>

namespace mote::test {
namespace {

/// The standard distributions differ from library to library; these do not.
class BeamNumbers {
  public:
    explicit BeamNumbers(std::uint64_t seed) : engine_(seed) {}
    double even() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
    double normal() {
        const double radius = std::sqrt(-2.0 * std::log(1.0 - even()));
        return radius * std::cos(2.0 * std::numbers::pi * even());
    }

  private:
    std::mt19937_64 engine_;
};

glm::dvec3 corePoint(const BeamShape& shape, BeamNumbers& random) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return 0.5 + shape.coreSigma * glm::dvec3(x, 0.6 * y, 1.3 * z);
}

glm::dvec3 haloPoint(const BeamShape& shape, BeamNumbers& random) {
    const double angle = 2.0 * std::numbers::pi * random.even();
    const double radius = shape.haloRadius + shape.haloThickness * random.normal();
    const double height = 3.0 * shape.haloThickness * random.normal();
    // The ring is tilted, so that it passes in front of the core and behind it.
    return 0.5 + glm::dvec3(radius * std::cos(angle), height + 0.3 * radius * std::sin(angle),
                            radius * std::sin(angle));
}

glm::dvec3 filamentPoint(std::size_t index, BeamNumbers& random) {
    const double along = random.even();
    const double angle = 0.5 * std::numbers::pi * static_cast<double>(index % 4) + 1.2 * along;
    const double radius = 0.1 + 0.36 * along;
    const double blur = 0.006;
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return 0.5 + radius * glm::dvec3(std::cos(angle), std::sin(angle), 0.5 - along) +
           blur * glm::dvec3(x, y, z);
}

}  // namespace

std::vector<WeightedPoint> beam(const BeamShape& shape) {
    BeamNumbers random(shape.seed);
    std::vector<WeightedPoint> points;
    const auto add = [&](const glm::dvec3& position) {
        const double weight = shape.evenWeights ? 1.0 : 0.5 + 1.5 * random.even();
        points.push_back({glm::clamp(position, 0.0, 1.0), weight});
    };
    for (std::size_t i = 0; i < shape.core; ++i) add(corePoint(shape, random));
    for (std::size_t i = 0; i < shape.halo; ++i) add(haloPoint(shape, random));
    for (std::size_t i = 0; i < shape.filaments; ++i) add(filamentPoint(i, random));
    return points;
}

std::vector<WeightedPoint> evenCloud(std::size_t count, std::uint64_t seed) {
    BeamNumbers random(seed);
    std::vector<WeightedPoint> points;
    for (std::size_t i = 0; i < count; ++i) {
        const double x = random.even(), y = random.even(), z = random.even();
        points.push_back({{x, y, z}, 1.0});
    }
    return points;
}

}  // namespace mote::test
