// SPDX-License-Identifier: GPL-3.0-or-later
//
// VectorDrawing: a picture of dots and strokes for paper: a sheet, what is neither as an image beneath, the
// strokes, and the dots as layers, one for each colour, which is a pen. drawVector makes the bytes of an SVG,
// EPS or PDF file of it. Pure functions, any thread; the same drawing gives the same bytes.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/scene/page.h"
#include "server/encode/vector/page_ink.h"
#include "server/encode/vector/sight.h"
#include "server/figures/marks.h"
#include "server/render/plan/dot.h"
#include "server/render/plan/picture.h"

namespace mote::server {

/// PageLayout: where a picture lies on its sheet: as large as the margins let it, in the middle. A value;
/// pure.
struct PageLayout {
    double width = 0.0;   ///< of the sheet, mm
    double height = 0.0;  ///< of the sheet, mm
    double scale = 0.0;   ///< of the picture, mm a pixel
    double left = 0.0;    ///< of the picture, mm
    double top = 0.0;     ///< of the picture, mm

    double x(double pixels) const { return left + scale * pixels; }  ///< mm from the sheet's left edge
    double y(double pixels) const { return top + scale * pixels; }   ///< mm from its upper edge
};

/// `width` and `height` of the picture in pixels, at least 1. If only one side of the sheet is given, the
/// other follows from the picture.
PageLayout layOut(const Page& page, std::uint32_t width, std::uint32_t height);

/// A dot on the sheet.
struct PageDot {
    double x = 0.0;       ///< mm from the sheet's left edge
    double y = 0.0;       ///< mm from its upper edge
    double radius = 0.0;  ///< mm
    double opacity = 1.0;
    glm::vec3 color{0.0F};                 ///< sRGB-encoded
    glm::vec3 beneath{1.0F};               ///< likewise: what it lies on, of a page without opacity
    std::vector<glm::dvec2> outline = {};  ///< of what is seen of it, mm from its centre; empty: all
};

/// What is drawn with one pen; a layer in programs that know them.
struct PageLayer {
    std::string name;
    std::vector<PageDot> dots;  ///< in the order in which they are drawn
};

struct VectorDrawing {
    std::uint32_t width = 0;     ///< of the picture, pixels
    std::uint32_t height = 0;    ///< of the picture, pixels
    glm::vec3 background{1.0F};  ///< linear RGB; white is bare paper
    std::optional<render::Picture>
        raster;         ///< srgb8, everything but dots and strokes, its background included
    render::Dots dots;  ///< in pixels
    /// In pixels, those in front first; not null.
    std::vector<std::shared_ptr<const render::Strokes>> strokes = {};
    std::shared_ptr<const Marks> annotations = {};  ///< in pixels, over all else; null: none
    /// What lies before the shapes of each list of strokes, and after those before the dots, among the image
    /// and what is drawn before them; null, or none at all: nothing.
    std::vector<std::shared_ptr<const Sight>> sights = {};
};

/// A drawing on its sheet.
struct PageDrawing {
    PageLayout layout;
    double pictureWidth = 0.0;   ///< mm
    double pictureHeight = 0.0;  ///< mm
    glm::vec3 background{1.0F};  ///< sRGB-encoded
    const render::Picture* raster = nullptr;
    std::vector<PageInk> inks;  ///< in the order in which they are drawn, before the layers
    std::vector<PageLayer> layers;
    const Marks* annotations = nullptr;  ///< in pixels of the picture, over all else
    bool plotter = false;
};

/// Dots as layers on the sheet: of each colour one, or one of all if there are more than 16; those behind
/// first, or along a short tour for a plotter. Strokes lie beneath them, each list by itself.
PageDrawing placeOnPage(const VectorDrawing& drawing, const Page& page);

/// Errors: resourceExhausted (memory), internal.
Result<std::vector<std::uint8_t>> drawVector(const VectorDrawing& drawing, const Page& page);

/// The writers that drawVector chooses from.
Result<std::vector<std::uint8_t>> writeSvg(const PageDrawing& drawing);
Result<std::vector<std::uint8_t>> writeCairo(const PageDrawing& drawing, proto::Page::Format format);
/// A PNG file. Errors: resourceExhausted, internal.
Result<std::vector<std::uint8_t>> encodePng(const render::Picture& picture);

}  // namespace mote::server
