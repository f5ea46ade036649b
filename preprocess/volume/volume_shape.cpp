// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/volume/volume_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace mote::prep {
namespace {

constexpr std::size_t maxUnit = 16;
// Axes of length 1 that span less than this volume lie in one plane, but for rounding.
constexpr double leastVolume = 1e-6;
constexpr double leastLength = 1e-30, greatestLength = 1e30;  // lest products of lengths overflow

}  // namespace

Status setDimensions(VolumeShape& shape, std::uint64_t nx, std::uint64_t ny, std::uint64_t nz,
                     const std::string& where) {
    const auto [least, greatest] = std::minmax({nx, ny, nz});
    if (least == 0) {
        return Error{ErrorCode::corrupt, where, fmt::format("says {} x {} x {}: no voxels", nx, ny, nz)};
    }
    if (greatest > VolumeShape::maxDimension) {
        return Error{ErrorCode::resourceExhausted, where,
                     fmt::format("says {} x {} x {} voxels; at most {} are read along an axis", nx, ny, nz,
                                 VolumeShape::maxDimension)};
    }
    shape.nx = static_cast<std::uint32_t>(nx);
    shape.ny = static_cast<std::uint32_t>(ny);
    shape.nz = static_cast<std::uint32_t>(nz);
    return success();
}

Status setPlacement(VolumeShape& shape, const glm::dmat3& axes, const glm::dvec3& origin,
                    const std::string& where) {
    double product = 1.0;
    for (int i = 0; i < 3; ++i) {
        const double length = glm::length(axes[i]);
        if (!(length > leastLength && length < greatestLength)) {
            return Error{ErrorCode::corrupt, where,
                         fmt::format("says that voxels along axis {} lie {} apart", "xyz"[i], length)};
        }
        product *= length;
        if (!(std::abs(origin[i]) < greatestLength)) {
            return Error{ErrorCode::corrupt, where, "says an origin that is no place"};
        }
        shape.indexToWorld[i] = glm::dvec4(axes[i], 0.0);
    }
    if (!(std::abs(glm::determinant(axes)) > leastVolume * product)) {
        return Error{ErrorCode::corrupt, where, "says axes that lie in one plane"};
    }
    shape.indexToWorld[3] = glm::dvec4(origin, 1.0);
    return success();
}

std::string printableText(std::string_view text) {
    std::string printable(text);
    std::replace_if(
        printable.begin(), printable.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return printable;
}

std::string unitText(std::string_view text) {
    return printableText(text) == text && text.size() <= maxUnit ? std::string(text) : std::string();
}

}  // namespace mote::prep
