// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/figure_sheet.h"

#include <cairo-pdf.h>
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "protocol/scene/length_scale.h"
#include "server/figures/cairo_surface.h"
#include "server/figures/draw_marks.h"
#include "server/figures/svg_marks.h"

namespace mote::server {
namespace {

constexpr double pointsInMm = inchInPoints / inchInMillimeters;
constexpr double sheetTitleSize = 1.1;  // of the font's

PlotLook lookOf(const FigureStyle& style) {
    PlotLook look;
    look.font = style.fontPoints;
    look.line = 0.075 * style.fontPoints;
    look.ink = {glm::dvec3(style.dark ? 1.0 : 0.0)};
    look.paper = glm::dvec3(style.dark ? 0.0 : 1.0);
    return look;
}

Error withoutPlace(cairo_status_t status) {
    return cairoError(status, "figure");
}

}  // namespace

FigureSheet::FigureSheet(const FigureStyle& style)
    : style_(style), size_(style.width * pointsInMm, style.height * pointsInMm), look_(lookOf(style)) {
    const double margin = 0.5 * look_.font;
    area_ = {glm::dvec2(margin), size_ - margin};
    marks_.push_back(AreaMark{{{0.0, 0.0}, {size_.x, 0.0}, size_, {0.0, size_.y}}, {look_.paper}});
    if (style.title.empty()) return;
    const double font = sheetTitleSize * look_.font;
    const auto text = shortened(upright(style.title), font, area_.size().x, typeface_);
    marks_.push_back(TextMark{text, {area_.center().x, area_.low.y}, font, {0.5, 0.0}, 0.0, look_.ink});
    area_.low.y += (Typeface::ascent + Typeface::descent) * font + look_.gap();
}

Result<FigureDocument> FigureSheet::document() const {
    if (style_.format == proto::FigureQuery::PNG) return png();
    return style_.format == proto::FigureQuery::PDF ? pdf() : svg();
}

Result<FigureDocument> FigureSheet::png() const {
    FigureDocument document{{}, style_.pixelWidth(), style_.pixelHeight()};
    const CairoSurface surface(cairo_image_surface_create(
        CAIRO_FORMAT_RGB24, static_cast<int>(document.width), static_cast<int>(document.height)));
    const CairoContext context(cairo_create(surface.get()));
    cairo_scale(context.get(), document.width / size_.x, document.height / size_.y);
    drawMarks(context.get(), marks_, typeface_, TextAs::outlines);
    if (const auto status = cairo_status(context.get()); status != CAIRO_STATUS_SUCCESS)
        return withoutPlace(status);
    MOTE_ASSIGN_OR_RETURN(document.bytes, pngOf(surface.get()));
    return document;
}

Result<FigureDocument> FigureSheet::svg() const {
    MOTE_ASSIGN_OR_RETURN(const auto elements, svgOf(marks_, typeface_));
    const auto text = fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" "
        "version=\"1.1\" width=\"{}mm\" height=\"{}mm\" viewBox=\"0 0 {} {}\">\n{}</svg>\n",
        shortNumber(style_.width), shortNumber(style_.height), shortNumber(size_.x), shortNumber(size_.y),
        elements);
    return FigureDocument{{text.begin(), text.end()}};
}

Result<FigureDocument> FigureSheet::pdf() const {
    FigureDocument document;
    {
        const CairoSurface surface(
            cairo_pdf_surface_create_for_stream(appendBytes, &document.bytes, size_.x, size_.y));
        const CairoContext context(cairo_create(surface.get()));
        drawMarks(context.get(), marks_, typeface_, TextAs::text);
        cairo_show_page(context.get());
        if (const auto status = cairo_status(context.get()); status != CAIRO_STATUS_SUCCESS)
            return withoutPlace(status);
        cairo_surface_finish(surface.get());
        if (const auto status = cairo_surface_status(surface.get()); status != CAIRO_STATUS_SUCCESS)
            return withoutPlace(status);
    }
    removePdfDate(document.bytes);
    return document;
}

RichText countText(const CountUnit& unit) {
    if (!unit.weighted || unit.weightUnit == "1") return upright("particles per bin");
    return upright(unit.weightUnit == "C" ? "charge per bin" : "weight per bin");
}

std::string countUnit(const CountUnit& unit) {
    return unit.weighted && unit.weightUnit == "C" ? "C" : "1";
}

StepPlaces placesOf(const std::vector<double>& times) {
    bool ascend = true;
    for (std::size_t i = 0; i < times.size(); ++i) {
        ascend = ascend && std::isfinite(times[i]) && std::abs(times[i]) < 1e300;
        if (i > 0) ascend = ascend && times[i] > times[i - 1];
    }
    if (ascend && times.size() > 1) return {times, upright("time"), "s"};
    StepPlaces places{{}, upright("step"), "1"};
    for (std::size_t i = 0; i < times.size(); ++i) places.places.push_back(static_cast<double>(i));
    return places;
}

}  // namespace mote::server
