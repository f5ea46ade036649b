// SPDX-License-Identifier: GPL-3.0-or-later
//
// StrokeHits: what strokes are in each pixel (docs/PICTURE.md, "Strokes"): every segment and every edge tried
// for every pixel, in double precision. Pure, safe on any number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/scene/view.h"
#include "server/render/plan/stroke.h"
#include "tests/reference/hit.h"

namespace mote::reference {

class StrokeHits {
  public:
    /// Both must outlive it.
    StrokeHits(const View& view, const render::Strokes& strokes) : view_(view), strokes_(strokes) {}

    /// Appends the hits of a row of pixels, in no order.
    void addRow(std::uint32_t row, std::vector<Hit>& hits) const;

  private:
    void addPixel(std::uint32_t column, std::uint32_t row, std::vector<Hit>& hits) const;
    void fade(std::vector<Hit>& hits) const;
    double areaDepthAt(std::uint32_t column, std::uint32_t row) const;
    double shareOf(const render::InkArea& area, std::uint32_t column, std::uint32_t row) const;

    const View& view_;
    const render::Strokes& strokes_;
};

}  // namespace mote::reference
