// SPDX-License-Identifier: GPL-3.0-or-later
//
// Writes pixels as a PNG that appears by one rename.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "protocol/scene/error.h"

namespace mote::client {

/// RGB, 8 bits, row 0 on top. Errors: permissionDenied or resourceExhausted with the file's name.
Status writeScreenshot(const std::filesystem::path& path, std::span<const std::uint8_t> rgb, int width,
                       int height);

}  // namespace mote::client
