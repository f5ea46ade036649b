// SPDX-License-Identifier: GPL-3.0-or-later
//
// AnnotationRoom: what of a picture is taken by letters and bars already, so that none lies over another or
// beyond the edge; and the marks that were put there. One owner, one thread.
#pragma once

#include <vector>

#include "server/figures/marks.h"
#include "server/figures/plot_axis.h"
#include "server/figures/quad.h"
#include "server/figures/typeface.h"

namespace mote::server {

class AnnotationRoom {
  public:
    AnnotationRoom(std::uint32_t width, std::uint32_t height, const PlotLook& look)
        : picture_{{0.0, 0.0}, {width, height}}, look_(look) {}

    const Box& picture() const { return picture_; }
    const PlotLook& look() const { return look_; }
    const Typeface& typeface() const { return typeface_; }
    Marks& marks() { return marks_; }

    /// Whether a text would lie in the picture and over nothing.
    bool isFree(const TextMark& text) const { return isFree(quadOf(text, typeface_)); }
    bool isFree(const Quad& quad) const {
        if (!picture_.holds(boxAround(quad))) return false;
        for (const auto& other : taken_) {
            if (meet(quad, other)) return false;
        }
        return true;
    }
    void take(const Quad& quad) { taken_.push_back(quad); }
    /// A text in black or white, as the look asks for.
    TextMark text(RichText words, const glm::dvec2& place, const glm::dvec2& anchor,
                  double angle = 0.0) const {
        return {std::move(words), place, look_.font, anchor, angle, look_.ink, look_.halo};
    }
    /// Draws it, and takes its place.
    void put(const TextMark& text) {
        take(quadOf(text, typeface_));
        marks_.push_back(text);
    }

  private:
    const Box picture_;
    const PlotLook look_;
    Typeface typeface_;
    std::vector<Quad> taken_;
    Marks marks_;
};

}  // namespace mote::server
