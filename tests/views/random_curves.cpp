// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/random_curves.h"

#include <algorithm>

#include "protocol/scene/color_map.h"

namespace mote::test {
namespace {

using Knots = std::vector<Curve::Knot>;

/// In [0, 1], often an end.
double anyPlace(Random& random) {
    if (random.chance(0.15)) return 0.0;
    return random.chance(0.15) ? 1.0 : random.unit();
}

std::vector<double> places(Random& random, std::size_t count) {
    std::vector<double> all;
    for (std::size_t i = 0; i < count; ++i) all.push_back(anyPlace(random));
    std::sort(all.begin(), all.end());
    return all;
}

Knots ramp(Random& random) {
    const auto at = places(random, 2);
    const bool falls = random.chance(0.2);
    return {{at[0], falls ? 1.0 : 0.0}, {at[1], falls ? 0.0 : 1.0}};
}

/// Something between two places, nothing beside them; steep sides are steps.
Knots band(Random& random) {
    const auto at = places(random, 4);
    if (random.chance(0.5)) return {{at[0], 0.0}, {at[1], 1.0}, {at[2], 1.0}, {at[3], 0.0}};
    return {{at[0], 0.0}, {at[0], 1.0}, {at[2], 1.0}, {at[2], 0.0}};
}

/// Knots in threes and fours at one place: only the first and the last of them are met.
Knots ties(Random& random) {
    Knots knots;
    for (const double at : places(random, 1 + random.below(3))) {
        for (auto more = 3 + random.below(2); more > 0; --more) knots.push_back({at, random.unit()});
    }
    return knots;
}

Knots anyOf(Random& random, std::size_t count) {
    Knots knots;
    for (const double at : places(random, count)) knots.push_back({at, anyPlace(random)});
    return knots;
}

Knots unitKnots(Random& random) {
    switch (random.below(12)) {
        case 0:
            return {{anyPlace(random), 1.0}};
        case 1:
            return {{0.0, 0.0}, {1.0, 0.0}};
        case 2:
            return ties(random);
        case 3:
            return anyOf(random, random.chance(0.2) ? 256 : 5);
        case 4:
        case 5:
        case 6:
            return band(random);
        default:
            return ramp(random);
    }
}

}  // namespace

std::vector<Curve::Knot> anyKnots(Random& random, const ValueRange& range) {
    auto knots = unitKnots(random);
    const double most = random.oneOf({1.0, 0.9, 0.5, 0.3, 0.1, 0.02, 0.001});
    for (auto& knot : knots) {
        knot.x = std::clamp(range.low + knot.x * (range.high - range.low), range.low, range.high);
        knot.y *= most;
    }
    return knots;
}

double anyShare(Random& random) {
    switch (random.below(6)) {
        case 0:
            return 1.0;
        case 1:
            return random.oneOf({0.0, 1e-6, 0.003, 0.999, 0.9999, 0.99999});
        default:
            return random.unit();
    }
}

void setAnyColor(Random& random, google::protobuf::RepeatedField<double>* color) {
    for (int i = 0; i < 3; ++i) color->Add(anyPlace(random));
}

std::string anyColorMap(Random& random) {
    const auto names = ColorMap::names();
    return std::string(names[random.below(names.size())]);
}

}  // namespace mote::test
