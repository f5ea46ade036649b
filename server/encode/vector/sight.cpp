// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/sight.h"

#include <algorithm>

namespace mote::server {
namespace {

constexpr float nothing = 0.004F;  // a step of 256

}  // namespace

bool InFront::clear() const {
    return through >= 1.0F - nothing && std::max({light.x, light.y, light.z}) <= 0.5F * nothing;
}

bool InFront::hidden() const {
    return through <= nothing;
}

InFront Sight::at(std::uint32_t column, std::uint32_t row, double depth) const {
    const SightPlace place{row * width_ + column, depth};
    const auto found = std::lower_bound(places_.begin(), places_.end(), place);
    if (found == places_.end() || *found != place) return {};
    return inFront_[static_cast<std::size_t>(found - places_.begin())];
}

}  // namespace mote::server
