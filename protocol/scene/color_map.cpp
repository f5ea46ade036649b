// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/color_map.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <glm/common.hpp>

#include "protocol/scene/color_map_tables.h"
#include "protocol/scene/srgb.h"

namespace mote {

Result<ColorMap> ColorMap::find(std::string_view name) {
    const auto index = std::find(colorMapNames.begin(), colorMapNames.end(), name) - colorMapNames.begin();
    if (index == static_cast<std::ptrdiff_t>(colorMapNames.size())) {
        return Error{ErrorCode::notFound, "",
                     fmt::format("no colour map is called \"{}\"; there are {}", name,
                                 fmt::join(colorMapNames, ", "))};
    }
    return ColorMap(colorMapNames[index], colorMapTables[index]);
}

ColorMap ColorMap::standard() {
    return find(defaultName).value();
}

std::span<const std::string_view> ColorMap::names() {
    return colorMapNames;
}

glm::dvec3 ColorMap::operator()(double x) const {
    const std::size_t last = srgb_.size() / 3 - 1;
    const double position = std::clamp(x, 0.0, 1.0) * static_cast<double>(last);
    const std::size_t below = std::min(static_cast<std::size_t>(position), last - 1);
    const auto color = [&](std::size_t i) {
        return glm::dvec3(srgbByteToLinear(srgb_[3 * i]), srgbByteToLinear(srgb_[3 * i + 1]),
                          srgbByteToLinear(srgb_[3 * i + 2]));
    };
    return glm::mix(color(below), color(below + 1), position - static_cast<double>(below));
}

}  // namespace mote
