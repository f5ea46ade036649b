// SPDX-License-Identifier: GPL-3.0-or-later
//
// EPS and PDF by Cairo; PNG, too.
#include <cairo-pdf.h>
#include <cairo-ps.h>
#include <cairo.h>
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <span>
#include <string_view>

#include "protocol/base/mote_check.h"
#include "protocol/scene/length_scale.h"
#include "server/encode/vector/vector_drawing.h"
#include "server/figures/cairo_surface.h"
#include "server/figures/draw_marks.h"

namespace mote::server {
namespace {

constexpr double pointsPerMm = inchInPoints / inchInMillimeters;
/// A pen must be moved to leave a mark; so little that it is still a dot.
constexpr double strokeLength = 0.01;  // mm

using Surface = CairoSurface;
using Context = CairoContext;
using Bytes = DocumentBytes;

Surface rasterSurface(const render::Picture& picture) {
    MOTE_CHECK(picture.format == render::PixelFormat::srgb8);
    Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(picture.width),
                                               static_cast<int>(picture.height)));
    if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS) return surface;
    auto* row = cairo_image_surface_get_data(surface.get());
    const auto stride = cairo_image_surface_get_stride(surface.get());
    const std::uint8_t* from = picture.pixels.data();
    for (std::uint32_t y = 0; y < picture.height; ++y, row += stride) {
        for (std::uint32_t x = 0; x < picture.width; ++x, from += 4) {
            const std::uint32_t pixel =
                (std::uint32_t{from[0]} << 16) | (std::uint32_t{from[1]} << 8) | from[2];
            std::memcpy(row + 4 * std::size_t{x}, &pixel, 4);
        }
    }
    cairo_surface_mark_dirty(surface.get());
    return surface;
}

void paintBeneath(cairo_t* context, const PageDrawing& drawing) {
    const auto& layout = drawing.layout;
    if (drawing.raster) {
        const auto raster = rasterSurface(*drawing.raster);
        cairo_save(context);
        cairo_translate(context, layout.left, layout.top);
        cairo_scale(context, drawing.pictureWidth / drawing.raster->width,
                    drawing.pictureHeight / drawing.raster->height);
        cairo_set_source_surface(context, raster.get(), 0.0, 0.0);
        // A pixel is a square on a page: smoothed, light would leave it for its neighbours.
        cairo_pattern_set_filter(cairo_get_source(context), CAIRO_FILTER_NEAREST);
        cairo_paint(context);
        cairo_restore(context);
    } else if (drawing.background != glm::vec3(1.0F)) {
        const auto& color = drawing.background;
        cairo_set_source_rgb(context, color.x, color.y, color.z);
        cairo_rectangle(context, layout.left, layout.top, drawing.pictureWidth, drawing.pictureHeight);
        cairo_fill(context);
    }
}

/// PostScript knows no transparency, and Cairo would make the whole page an image for it: there a dot, or
/// ink, is as pale as it would be on what lies beneath it.
void setColor(cairo_t* context, const glm::vec3& full, double opacity, const glm::vec3& beneath, bool blend) {
    const auto share = static_cast<float>(opacity);
    const auto color = blend ? full * share + beneath * (1.0F - share) : full;
    cairo_set_source_rgba(context, color.x, color.y, color.z, blend ? 1.0 : opacity);
}

/// What is seen of a dot.
void drawPiece(cairo_t* context, const PageDot& dot) {
    for (const auto& corner : dot.outline) cairo_line_to(context, dot.x + corner.x, dot.y + corner.y);
    cairo_close_path(context);
    cairo_fill(context);
}

/// A stroke with a round pen, of no length or nearly none: smaller by far than a path of four curves.
void drawDots(cairo_t* context, const PageDrawing& drawing, bool blend) {
    cairo_set_line_cap(context, CAIRO_LINE_CAP_ROUND);
    const double length = drawing.plotter ? strokeLength : 0.0;
    for (const auto& layer : drawing.layers) {
        for (const auto& dot : layer.dots) {
            setColor(context, dot.color, dot.opacity, dot.beneath, blend);
            if (!dot.outline.empty()) {
                drawPiece(context, dot);
                continue;
            }
            cairo_set_line_width(context, 2.0 * dot.radius);
            cairo_move_to(context, dot.x - 0.5 * length, dot.y);
            cairo_line_to(context, dot.x + 0.5 * length, dot.y);
            cairo_stroke(context);
        }
    }
}

void addPath(cairo_t* context, std::span<const glm::dvec2> points) {
    cairo_move_to(context, points[0].x, points[0].y);
    if (points.size() == 1) cairo_line_to(context, points[0].x, points[0].y);
    for (const auto& point : points.subspan(1)) cairo_line_to(context, point.x, point.y);
}

void addOutline(cairo_t* context, std::span<const glm::dvec2> points) {
    addPath(context, points);
    cairo_close_path(context);
}

void drawInk(cairo_t* context, const PageInk& ink) {
    cairo_set_fill_rule(context, CAIRO_FILL_RULE_EVEN_ODD);
    for (const auto& area : ink.areas) {
        for (std::size_t i = 0; i < area.size(); ++i) addOutline(context, area.of(i));
        cairo_fill(context);
    }
    cairo_set_fill_rule(context, CAIRO_FILL_RULE_WINDING);
    for (std::size_t i = 0; i < ink.outlines.size(); ++i) {
        addOutline(context, ink.outlines.of(i));
        cairo_fill(context);
    }
    for (const auto& [width, lines] : ink.lines) {
        cairo_set_line_width(context, width);
        for (std::size_t i = 0; i < lines.size(); ++i) {
            addPath(context, lines.of(i));
            cairo_stroke(context);
        }
    }
}

/// In pixels of the picture, and beyond its edge nothing.
void drawInks(cairo_t* context, const PageDrawing& drawing, bool blend) {
    if (drawing.inks.empty()) return;
    const auto& layout = drawing.layout;
    cairo_save(context);
    cairo_rectangle(context, layout.left, layout.top, drawing.pictureWidth, drawing.pictureHeight);
    cairo_clip(context);
    cairo_translate(context, layout.left, layout.top);
    cairo_scale(context, layout.scale, layout.scale);
    cairo_set_line_cap(context, CAIRO_LINE_CAP_ROUND);
    cairo_set_line_join(context, CAIRO_LINE_JOIN_ROUND);
    for (const auto& ink : drawing.inks) {
        const bool group = ink.opacity < 1.0 && !blend;
        if (group) cairo_push_group(context);
        const auto draw = [&](const PageInk& part) {
            setColor(context, part.color, group ? 1.0 : ink.opacity, part.beneath, blend);
            drawInk(context, part);
        };
        draw(ink);
        for (const auto& part : ink.parts) draw(part);
        if (!group) continue;
        cairo_pop_group_to_source(context);
        cairo_paint_with_alpha(context, ink.opacity);
    }
    cairo_restore(context);
}

void drawMarksOf(cairo_t* context, const PageDrawing& drawing, bool blend) {
    if (drawing.annotations == nullptr) return;
    cairo_save(context);
    cairo_translate(context, drawing.layout.left, drawing.layout.top);
    cairo_scale(context, drawing.layout.scale, drawing.layout.scale);
    const Typeface typeface;
    const auto& marks = *drawing.annotations;
    drawMarks(context, blend ? flattened(marks, drawing.background) : marks, typeface, TextAs::text);
    cairo_restore(context);
}

Surface makeSurface(proto::Page::Format format, const PageLayout& layout, Bytes& bytes) {
    const double width = layout.width * pointsPerMm;
    const double height = layout.height * pointsPerMm;
    if (format == proto::Page::EPS) {
        Surface surface(cairo_ps_surface_create_for_stream(appendBytes, &bytes, width, height));
        cairo_ps_surface_set_eps(surface.get(), true);
        return surface;
    }
    return Surface(cairo_pdf_surface_create_for_stream(appendBytes, &bytes, width, height));
}

/// Replaces the line of an EPS file's header that begins so, and its newline. Does nothing if there is none.
void replaceLine(Bytes& bytes, std::string_view begin, std::string_view line) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const auto at = text.find(begin);
    if (at == std::string_view::npos) return;
    const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const auto after = bytes.erase(first, first + static_cast<std::ptrdiff_t>(text.find('\n', at) + 1 - at));
    bytes.insert(after, line.begin(), line.end());
}

/// The same drawing is to give the same bytes, without a date; and an EPS file's box is the sheet, where
/// Cairo has what is drawn on it: so it is as large as the same as SVG or PDF.
void mend(proto::Page::Format format, const PageLayout& layout, Bytes& bytes) {
    if (format != proto::Page::EPS) return removePdfDate(bytes);
    replaceLine(bytes, "%%CreationDate:", "");
    const double width = layout.width * pointsPerMm, height = layout.height * pointsPerMm;
    const auto box = fmt::format("BoundingBox: 0 0 {:.0f} {:.0f}\n", std::ceil(width), std::ceil(height));
    replaceLine(bytes, "%%BoundingBox:",
                fmt::format("%%{}%%HiResBoundingBox: 0 0 {:.4f} {:.4f}\n", box, width, height));
    replaceLine(bytes, "%%PageBoundingBox:", "%%Page" + box);
}

}  // namespace

Result<Bytes> writeCairo(const PageDrawing& drawing, proto::Page::Format format) {
    Bytes bytes;
    const auto surface = makeSurface(format, drawing.layout, bytes);
    const Context context(cairo_create(surface.get()));
    cairo_scale(context.get(), pointsPerMm, pointsPerMm);
    paintBeneath(context.get(), drawing);
    drawInks(context.get(), drawing, format == proto::Page::EPS);
    drawDots(context.get(), drawing, format == proto::Page::EPS);
    drawMarksOf(context.get(), drawing, format == proto::Page::EPS);
    cairo_show_page(context.get());
    if (const auto status = cairo_status(context.get()); status != CAIRO_STATUS_SUCCESS)
        return cairoError(status, "page");
    cairo_surface_finish(surface.get());
    const auto status = cairo_surface_status(surface.get());
    if (status != CAIRO_STATUS_SUCCESS) return cairoError(status, "page");
    mend(format, drawing.layout, bytes);
    return bytes;
}

Result<Bytes> encodePng(const render::Picture& picture) {
    const auto surface = rasterSurface(picture);
    Bytes bytes;
    const auto status = cairo_surface_write_to_png_stream(surface.get(), appendBytes, &bytes);
    if (status != CAIRO_STATUS_SUCCESS) return cairoError(status, "page");
    return bytes;
}

}  // namespace mote::server
