// SPDX-License-Identifier: GPL-3.0-or-later
//
// What Siemens' scanners write into a private element of their own (its form "SV10") of pictures that are
// mosaics: all slices of a volume in one picture, row by row. Pure; from bytes that nobody vouches for.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string_view>

namespace mote::prep {

struct DicomMosaic {
    std::uint32_t tiles = 0;  ///< slices, at least 1
    glm::dvec3 normal{0.0};   ///< from each to the next one, of unit length, LPS
};

/// None where the bytes are something else, or do not say both.
std::optional<DicomMosaic> siemensMosaic(std::string_view bytes);

}  // namespace mote::prep
