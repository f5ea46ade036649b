// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/vector_drawing.h"

#include <algorithm>
#include <glm/common.hpp>
#include <limits>
#include <map>
#include <numeric>

#include "protocol/scene/srgb.h"
#include "server/encode/vector/tour.h"
#include "server/figures/svg_marks.h"

namespace mote::server {
namespace {

constexpr std::size_t mostPens = 16;

glm::vec3 encoded(const glm::vec3& linear) {
    return glm::vec3(linearToSrgb(glm::clamp(glm::dvec3(linear), 0.0, 1.0)));
}

/// The largest dots get the diameter that is asked for, the others in proportion.
double radiusScale(const render::Dots& dots, const Page& page, const PageLayout& layout) {
    float largest = 0.0F;
    for (const auto& dot : dots) largest = std::max(largest, dot.radius);
    return page.dot > 0.0 && largest > 0.0F ? 0.5 * page.dot / largest : layout.scale;
}

/// Indices of the dots, those behind first: of equal depth, the earlier lies in front.
std::vector<std::size_t> backToFront(const render::Dots& dots) {
    std::vector<std::size_t> order(dots.size());
    std::iota(order.rbegin(), order.rend(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](auto a, auto b) { return dots[a].depth > dots[b].depth; });
    return order;
}

void orderForPen(std::vector<PageDot>& dots) {
    std::vector<glm::dvec2> places;
    for (const auto& dot : dots) places.emplace_back(dot.x, dot.y);
    std::vector<PageDot> ordered;
    for (const auto index : shortTour(places)) ordered.push_back(dots[index]);
    dots = std::move(ordered);
}

}  // namespace

PageLayout layOut(const Page& page, std::uint32_t width, std::uint32_t height) {
    const double margins = 2.0 * page.margin;
    PageLayout layout;
    layout.scale = std::numeric_limits<double>::max();
    if (page.width > 0.0) layout.scale = (page.width - margins) / width;
    if (page.height > 0.0) layout.scale = std::min(layout.scale, (page.height - margins) / height);
    if (page.width == 0.0 && page.height == 0.0) layout.scale = Page::pixelSize;
    layout.width = page.width > 0.0 ? page.width : layout.scale * width + margins;
    layout.height = page.height > 0.0 ? page.height : layout.scale * height + margins;
    layout.left = 0.5 * (layout.width - layout.scale * width);
    layout.top = 0.5 * (layout.height - layout.scale * height);
    return layout;
}

PageDrawing placeOnPage(const VectorDrawing& drawing, const Page& page) {
    PageDrawing placed;
    placed.layout = layOut(page, drawing.width, drawing.height);
    placed.pictureWidth = placed.layout.scale * drawing.width;
    placed.pictureHeight = placed.layout.scale * drawing.height;
    placed.background = encoded(drawing.background);
    placed.raster = drawing.raster ? &*drawing.raster : nullptr;
    placed.annotations = drawing.annotations.get();
    placed.plotter = page.plotter;
    for (auto list = drawing.strokes.rbegin(); list != drawing.strokes.rend(); ++list) {
        auto ink = inkOnPage(**list, drawing.width, drawing.height, page.plotter);
        ink.color = encoded((*list)->color);
        ink.opacity = (*list)->opacity;
        ink.name = "ink " + hexColor(ink.color);
        placed.inks.push_back(std::move(ink));
    }
    const double scale = radiusScale(drawing.dots, page, placed.layout);
    std::map<std::string, std::vector<PageDot>> pens;
    std::vector<PageDot> all;
    for (const auto index : backToFront(drawing.dots)) {
        const auto& dot = drawing.dots[index];
        all.push_back({placed.layout.x(dot.x), placed.layout.y(dot.y), scale * dot.radius, dot.opacity,
                       encoded(dot.color)});
        if (pens.size() <= mostPens) pens["dots " + hexColor(all.back().color)].push_back(all.back());
    }
    if (pens.size() > mostPens) pens = {{"dots", std::move(all)}};
    for (auto& [name, dots] : pens) {
        if (page.plotter) orderForPen(dots);
        placed.layers.push_back({name, std::move(dots)});
    }
    return placed;
}

Result<std::vector<std::uint8_t>> drawVector(const VectorDrawing& drawing, const Page& page) {
    const auto placed = placeOnPage(drawing, page);
    return page.format == proto::Page::SVG ? writeSvg(placed) : writeCairo(placed, page.format);
}

}  // namespace mote::server
