// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which lines of a scene a pen draws (the dissertation's section 2.3.5.3): those that part what lies far
// apart, and of the others, where all of them would be too dark, those that bring the tone nearest to its
// target. Pure.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "protocol/scene/ink_style.h"
#include "server/render/ink/carry.h"
#include "server/render/ink/ink_line.h"
#include "server/render/ink/tone_grid.h"

namespace mote::render {

/// What the choice is made by, on one grid of cells.
struct LineTarget {
    const ToneCells& cells;
    const ToneGrid& target;         ///< share of the paper that ink should cover, blurred
    double width;                   ///< of lines, pixels
    double longest;                 ///< of what is drawn or left out as one, pixels
    bool quick = false;             ///< lines are thinned out by their ranks, for a picture in motion
    const Carry* before = nullptr;  ///< by which lines stay as they were where they can; or null

    /// Whether lines are told part by part from those of the picture before.
    bool isOfFilm() const { return before != nullptr && !quick; }
};

struct ChosenLines {
    std::vector<InkLine> lines;  ///< pieces of those that there were, in their order
    std::vector<InkLine> left;   ///< likewise; that are not drawn
    ToneGrid density;            ///< of theirs, blurred (tone_grid.h)
};

/// The density of lines, blurred.
ToneGrid densityOf(const std::vector<InkLine>& lines, const ToneCells& cells, double width);

/// What each pixel of a picture sees, if what is seen ends there at once, as a surface does.
enum class Sight : std::uint8_t { nothing, something, inked };

/// Draws what is missing of outer contours. Of the lines that are left those that lie beside nothing, and
/// those between pixels that see something and pixels that see nothing, are drawn where no line is within
/// about two pixels; where there is none to draw, as at the plane nearer than which nothing is seen, the
/// border itself. `sight`: without pixels where borders tell nothing; beside inked ones no line is missing.
void makeContoursWhole(const Raster<Sight>& sight, const Raster<float>& depth, const LineTarget& target,
                       ChosenLines& chosen, const std::stop_token& stop);

/// Chooses by the style's mode and importance.
ChosenLines chooseLines(const std::vector<InkLine>& lines, const SilhouetteStyle& style,
                        const LineTarget& target, const std::stop_token& stop);

}  // namespace mote::render
