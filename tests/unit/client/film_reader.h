// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a film's file holds, decoded by libav: for tests, and how near its frames are to what they were made
// of. Values and pure functions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace mote::test {

using Rgba = std::vector<std::uint8_t>;

struct Film {
    std::string codec, pixelFormat;                  ///< libav's names
    std::string range, primaries, transfer, matrix;  ///< of colours, as the decoder says
    std::string streamRange, streamPrimaries, streamTransfer, streamMatrix;  ///< and the container
    std::uint32_t width = 0, height = 0;                                     ///< pixels
    std::vector<Rgba> frames;                                                ///< alpha is 255
    std::vector<double> times;                                               ///< seconds
    double duration = 0;                                                     ///< seconds
};

/// Throws std::runtime_error where the file cannot be read to its end without an error.
Film readFilm(const std::filesystem::path& path);

std::vector<std::uint8_t> bytesOf(const std::filesystem::path& path);
std::size_t entriesOf(const std::filesystem::path& folder);

/// Of R, G and B over all frames, dB.
double psnr(const std::vector<Rgba>& a, const std::vector<Rgba>& b);

/// `count` frames of a turning cloud of points, one pixel each and half as many as there are pixels, before a
/// glow: the hardest that films of particles become.
std::vector<Rgba> particleFrames(std::uint32_t width, std::uint32_t height, std::size_t count, unsigned seed);

/// Fields of `side` x `side` pixels of one colour each.
Rgba flatFields(std::uint32_t width, std::uint32_t height, std::uint32_t side, unsigned seed);

}  // namespace mote::test
