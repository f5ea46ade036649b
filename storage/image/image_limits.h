// SPDX-License-Identifier: GPL-3.0-or-later
//
// How large a picture of a dataset may be. Constants.
#pragma once

#include <cstdint>

namespace mote::storage {

inline constexpr std::uint32_t maxImageSide = 1U << 17;                  ///< pixels
inline constexpr std::uint64_t maxImagePixels = std::uint64_t{1} << 28;  ///< pixels: a GiB of luminance

}  // namespace mote::storage
