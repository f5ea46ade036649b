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

    /// Dithers one row, `y` from the top: RGBA to an index a pixel.
    void row(std::uint32_t y, std::span<const std::uint8_t> rgba, std::uint8_t* indices);

  private:
    std::uint32_t mixOf(std::uint32_t rgb);

    std::vector<SeenColor> colors_;
    std::vector<std::uint32_t> mixes_;  ///< of each colour there is; 0: not known yet
};

/// The palette of a film, from all its frames. It counts colours in 64 x 64 x 64 cells, halves
/// the set where its spread is greatest until there are enough parts, and moves each colour into the middle
/// of those that are nearest to it. A film of few colours keeps them as they are. One owner, one thread at a
/// time; 8 MiB.
class PaletteMaker {
  public:
    PaletteMaker();

    /// RGBA pixels of a frame, sRGB-encoded; alpha is ignored.
    void add(std::span<const std::uint8_t> rgba);
    /// The same frames give the same palette. Black alone if nothing was added.
    GifPalette make() const;

  private:
    struct Cell {
        std::uint64_t count = 0, r = 0, g = 0, b = 0;  ///< sums
    };

    std::vector<Cell> cells_;
    std::vector<std::uint32_t> exact_;  ///< the distinct colours, ascending, while they are few
    bool few_ = true;
};

}  // namespace mote::client
