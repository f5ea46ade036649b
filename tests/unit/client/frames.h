// SPDX-License-Identifier: GPL-3.0-or-later
//
// Frames as a server sends them, made without the server's encoder: message and payload. Pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "protocol/mote.pb.h"

namespace mote::test {

/// RGBA of a picture without two like rows; alpha is 1. SRGB8 or LINEAR_HALF.
std::vector<std::uint8_t> samplePixels(std::uint32_t width, std::uint32_t height, proto::PixelFormat format);

proto::Frame frameMessage(std::uint32_t width, std::uint32_t height, proto::PixelFormat format,
                          proto::Frame::Encoding encoding);

/// The row filter and zstd.
std::string zstdPayload(const std::vector<std::uint8_t>& rgba, std::uint32_t width,
                        proto::PixelFormat format);

/// Quality 100, 4:4:4.
std::string jpegPayload(const std::vector<std::uint8_t>& rgba, std::uint32_t width);

}  // namespace mote::test
