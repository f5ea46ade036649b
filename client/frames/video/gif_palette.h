// SPDX-License-Identifier: GPL-3.0-or-later
//
// The colours of a GIF, and how a pixel becomes one of them. A film has one palette for all its frames, and
// dithers in a fixed pattern, so that what does not change keeps its bytes and nothing flickers.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace mote::client {

/// sRGB-encoded.
using RgbColor = std::array<std::uint8_t, 3>;

/// At most mostColors; the one index left over stands for "as in the frame before".
struct GifPalette {
    static constexpr std::size_t mostColors = 255;
    std::vector<RgbColor> colors;
};

/// A colour as three numbers whose distances are nearer to what the eye sees than those of R, G and B: luma,
/// and chroma at half its weight. In steps of 1/255 of luma.
struct SeenColor {
    double luma = 0, cb = 0, cr = 0;
};
SeenColor seenColor(double r, double g, double b);
double squareDistance(const SeenColor& a, const SeenColor& b);

/// Pixels to indices. One owner, one thread at a time: it remembers each colour that it has seen, in 64 MiB.
class GifDither {
  public:
    explicit GifDither(const GifPalette& palette);

    /// One row, `y` from the top: RGBA to an index a pixel.
    void row(std::uint32_t y, std::span<const std::uint8_t> rgba, std::uint8_t* indices);

  private:
    std::uint32_t mixOf(std::uint32_t rgb);

    std::vector<SeenColor> colors_;
    std::vector<std::uint32_t> mixes_;  ///< of each colour there is; 0: not known yet
};

}  // namespace mote::client
