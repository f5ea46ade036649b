// SPDX-License-Identifier: GPL-3.0-or-later
//
// Typeface: the glyphs of Mote's figures: Liberation Sans, upright and italic, whose files are part of the
// program, so that every machine draws the same. Glyphs are outlines without hints. Owned by whoever draws;
// one thread at a time.
//
// A character that the font lacks is its box for missing glyphs; one that only steers (directions, joiners)
// is nothing. Text stands in the order in which it is written: scripts from right to left are not turned.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <map>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "server/figures/rich_text.h"

struct FT_FaceRec_;

namespace mote::server {

/// A way of lines and of cubic curves, closed.
struct GlyphContour {
    glm::dvec2 begin{0.0};  ///< em, y down, from the glyph's origin on the baseline
    /// Three each: two that bend and an end. A line has both on it.
    std::vector<glm::dvec2> curves;
};

struct GlyphOutline {
    std::vector<GlyphContour> contours;  ///< filled by the nonzero rule
};

/// A glyph of a line of text.
struct PlacedGlyph {
    std::uint32_t index = 0;  ///< of the font
    bool italic = false;
    double size = 0.0;        ///< of an em
    glm::dvec2 place{0.0};    ///< of its origin, from the line's beginning on the baseline
    std::string_view source;  ///< what it shows, within the text
};

struct TextLine {
    std::vector<PlacedGlyph> glyphs;
    double width = 0.0;
};

class Typeface {
  public:
    static constexpr double capHeight = 0.72;  ///< em, of capitals and digits
    static constexpr double ascent = 0.76;     ///< em, above the baseline, of letters
    static constexpr double descent = 0.21;    ///< em, below it
    static constexpr double scriptSize = 0.7;  ///< of indices and exponents, of the text's
    static constexpr double raise = 0.36;      ///< em, of exponents
    static constexpr double lower = 0.17;      ///< em, of indices

    Typeface();
    ~Typeface();
    Typeface(const Typeface&) = delete;
    Typeface& operator=(const Typeface&) = delete;

    /// `size` of an em, in any unit, which is that of the result. Refers to the text.
    TextLine layOut(const RichText& text, double size) const;
    const GlyphOutline& outline(const PlacedGlyph& glyph) const;
    /// FreeType's, of the fonts' files; shared with who keeps it.
    std::shared_ptr<FT_FaceRec_> face(bool italic) const;

  private:
    struct Library;

    std::shared_ptr<Library> library_;
    std::shared_ptr<FT_FaceRec_> faces_[2];
    mutable std::map<std::pair<bool, std::uint32_t>, GlyphOutline> outlines_;  // of what was drawn
};

}  // namespace mote::server
