// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pen: lines, hatches and solid ink become strokes, with the hand that draws them. Appends to a list of
// strokes, whose owner owns it; one thread.
#pragma once

#include <stop_token>
#include <vector>

#include "server/render/ink/contour.h"
#include "server/render/ink/hatch.h"
#include "server/render/ink/ink_line.h"
#include "server/render/ink/modalities.h"
#include "server/render/plan/stroke.h"

namespace mote::render {

struct Hand {
    double waver = 0.0;  ///< standard deviation off the way, pixels
    bool taper = false;  ///< strokes grow thin towards their ends
};

class Pen {
  public:
    Pen(const Modalities& modalities, const Hand& hand, Strokes& strokes)
        : modalities_(modalities), hand_(hand), strokes_(strokes) {}

    /// Where the surface comes nearer beside a line, as it does inside a silhouette, the line comes with it.
    void draw(const InkLine& line, double width);
    /// A hatch lies at the depths of what is seen along it.
    void draw(const HatchStroke& stroke, double width);
    /// Outlines of one region after another are areas, at the depths of what is seen in each pixel or nearest
    /// to it. Once. If `stop` is requested meanwhile some depths are missing.
    void fill(const std::vector<Outline>& outlines, const std::stop_token& stop);

  private:
    struct Point {
        glm::dvec2 at;
        double depth, width;
    };
    /// A depth that is wanted, and by how much it may be missed.
    struct Aim {
        double depth, tolerance;
    };
    Aim aimBeside(const LinePoint& line) const;
    Aim aimOn(const glm::dvec2& place) const;
    double nearestAround(const glm::dvec2& place) const;
    void lay(const glm::dvec2& from, const glm::dvec2& to, double width);
    void put();
    void subdivide();
    void waver();
    void taper();

    const Modalities& modalities_;
    const Hand hand_;
    Strokes& strokes_;
    std::vector<Point> points_;  // of the stroke that is drawn
    std::vector<Aim> aims_;      // at places alike far from each other along a part of it
};

}  // namespace mote::render
