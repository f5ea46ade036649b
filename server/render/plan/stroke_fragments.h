// SPDX-License-Identifier: GPL-3.0-or-later
//
// Strokes become fragments (docs/PICTURE.md, "Strokes"): what lines and areas cover of each pixel, and at
// what depth. Made tile by tile; shared by all devices.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "server/render/plan/fragment.h"
#include "server/render/plan/stroke.h"
#include "server/render/plan/stroke_tiles.h"

namespace mote::render {

class StrokeFragments : public FragmentMaker {
  public:
    /// In a picture of so many pixels, no nearer than a depth. In turns (in_turns.h), on all threads of the
    /// calling arena. Throws std::bad_alloc.
    StrokeFragments(std::shared_ptr<const Strokes> strokes, std::uint32_t width, std::uint32_t height,
                    double nearDepth)
        : strokes_(std::move(strokes)),
          width_(width),
          height_(height),
          nearDepth_(nearDepth),
          tiles_(*strokes_, width, height) {}

    void make(const PixelRect& pixels, Fragments& fragments) const override;

    std::uint64_t bytes() const { return tiles_.bytes(); }

  private:
    void makeTile(std::uint32_t column, std::uint32_t row, const PixelRect& pixels,
                  Fragments& fragments) const;

    std::shared_ptr<const Strokes> strokes_;
    std::uint32_t width_, height_;
    double nearDepth_;
    StrokeTiles tiles_;
};

/// All of them, in parts, whose order counts as that of fragments does. In turns, on all threads of the
/// calling arena; the same fragments on any number of them. Throws std::bad_alloc.
std::vector<Fragments> strokeFragments(const Strokes& strokes, std::uint32_t width, std::uint32_t height,
                                       double nearDepth);

}  // namespace mote::render
