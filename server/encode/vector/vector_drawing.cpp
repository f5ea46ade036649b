// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/vector_drawing.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "protocol/scene/srgb.h"
#include "server/encode/vector/cut_shapes.h"
#include "server/encode/vector/tour.h"
#include "server/figures/svg_marks.h"
#include "server/render/plan/dot.h"

namespace mote::server {
namespace {

/// A pen that draws dots of a page: one a colour, those behind first, unless they are too many or none of
/// them could be drawn before another without covering what lies in front.
struct DotPen {
    std::string name;               ///< of its layer
    std::vector<std::size_t> dots;  ///< those behind first: of equal depth, the earlier lies in front
};

using render::Dots;

constexpr std::size_t mostPens = 16;

std::vector<std::size_t> backToFront(const Dots& dots) {
    std::vector<std::size_t> order(dots.size());
    std::iota(order.rbegin(), order.rend(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](auto a, auto b) { return dots[a].depth > dots[b].depth; });
    return order;
}

/// Finds dots that lie over one another, by squares that no dot exceeds.
class Overlaps {
  public:
    explicit Overlaps(const Dots& dots) : dots_(dots) {
        for (const auto& dot : dots) side_ = std::max(side_, 2.0F * dot.radius);
    }
    void add(std::size_t index) {
        squares_[keyOf(columnOf(dots_[index].x), columnOf(dots_[index].y))].push_back(index);
    }
    /// `check(other)` of all that were added and that it touches, until one is true. Whether one was.
    template <class Check>
    bool any(std::size_t index, Check&& check) const {
        const auto& dot = dots_[index];
        for (std::int64_t i = -1; i <= 1; ++i) {
            for (std::int64_t k = -1; k <= 1; ++k) {
                const auto square = squares_.find(keyOf(columnOf(dot.x) + i, columnOf(dot.y) + k));
                if (square == squares_.end()) continue;
                for (const auto other : square->second) {
                    const auto& at = dots_[other];
                    if (std::hypot(at.x - dot.x, at.y - dot.y) < at.radius + dot.radius && check(other))
                        return true;
                }
            }
        }
        return false;
    }

  private:
    std::int64_t columnOf(float at) const {
        return static_cast<std::int64_t>(std::floor(std::clamp(at / side_, -1e9F, 1e9F)));
    }
    static std::uint64_t keyOf(std::int64_t column, std::int64_t row) {
        return (static_cast<std::uint64_t>(column) << 32) ^ (static_cast<std::uint64_t>(row) & 0xffffffffU);
    }

    const Dots& dots_;
    float side_ = 1e-3F;
    std::unordered_map<std::uint64_t, std::vector<std::size_t>> squares_;
};

/// Whether a pen would draw over a dot of an earlier one that lies nearer.
bool cover(const std::vector<DotPen>& pens, const Dots& dots) {
    Overlaps drawn(dots);
    for (const auto& pen : pens) {
        for (const auto index : pen.dots) {
            if (drawn.any(index, [&](auto other) { return dots[other].depth < dots[index].depth; }))
                return true;
        }
        for (const auto index : pen.dots) drawn.add(index);
    }
    return false;
}

/// `plotter`: pens are colours whatever they cover.
std::vector<DotPen> pensOf(const Dots& dots, bool plotter) {
    auto order = backToFront(dots);
    std::vector<std::size_t> place(dots.size());
    for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = i;
    std::map<std::string, std::vector<std::size_t>> colors;
    for (const auto index : order) {
        colors["dots " + hexColor(encoded(dots[index].color))].push_back(index);
        if (colors.size() > mostPens) return {{"dots", std::move(order)}};
    }
    std::vector<DotPen> pens;
    for (auto& [name, its] : colors) pens.push_back({name, std::move(its)});
    if (plotter || pens.size() < 2) return pens;
    const auto middle = [&](const DotPen& pen) {
        double sum = 0.0;
        for (const auto index : pen.dots) sum += static_cast<double>(place[index]);
        return sum / static_cast<double>(pen.dots.size());
    };
    std::stable_sort(pens.begin(), pens.end(),
                     [&](const auto& a, const auto& b) { return middle(a) < middle(b); });
    if (cover(pens, dots)) return {{"dots", std::move(order)}};
    return pens;
}

/// Light of the image that the shapes lie on.
class Beneath {
  public:
    explicit Beneath(const VectorDrawing& drawing)
        : background_(drawing.background), raster_(drawing.raster ? &*drawing.raster : nullptr) {}

    glm::vec3 at(double x, double y) const {
        if (raster_ == nullptr) return background_;
        const auto pixel = pixelOf({x, y}, {raster_->width, raster_->height});
        const auto* from = &raster_->pixels[4 * (std::size_t{pixel.y} * raster_->width + pixel.x)];
        return glm::vec3(srgbToLinear(glm::dvec3(from[0], from[1], from[2]) / 255.0));
    }
    /// On average along them.
    glm::vec3 of(const render::Strokes& strokes) const {
        glm::vec3 sum(0.0F);
        for (const auto& point : strokes.points) sum += at(point.x, point.y);
        return strokes.points.empty() ? background_ : sum / static_cast<float>(strokes.points.size());
    }

  private:
    glm::vec3 background_;
    const render::Picture* raster_;
};

/// What lies before what is drawn as number `index`, strokes first; nothing if it is not told.
const Sight& sightOf(const VectorDrawing& drawing, std::size_t index) {
    static const Sight nothing(0, {}, {});
    return index < drawing.sights.size() && drawing.sights[index] ? *drawing.sights[index] : nothing;
}

/// The largest dots get the diameter that is asked for, the others in proportion.
double radiusScale(const render::Dots& dots, const Page& page, const PageLayout& layout) {
    float largest = 0.0F;
    for (const auto& dot : dots) largest = std::max(largest, dot.radius);
    return page.dot > 0.0 && largest > 0.0F ? 0.5 * page.dot / largest : layout.scale;
}

void orderForPen(std::vector<PageDot>& dots) {
    std::vector<glm::dvec2> places;
    for (const auto& dot : dots) places.emplace_back(dot.x, dot.y);
    std::vector<PageDot> ordered;
    for (const auto index : shortTour(places)) ordered.push_back(dots[index]);
    dots = std::move(ordered);
}

/// All of a pen in one colour: what is seen of it, and what opacity it has so as a group.
PageInk inkOf(const VectorDrawing& drawing, std::size_t index, bool plotter) {
    const auto& strokes = *drawing.strokes[index];
    const Beneath beneath(drawing);
    const auto seen = seenOf(strokes, sightOf(drawing, index), {drawing.width, drawing.height}, plotter);
    double opacity = 0.0;
    for (const auto& part : seen)
        opacity = std::max(opacity, paintOver(part.color, strokes.opacity, beneath.of(part)).opacity);
    PageInk ink;
    for (const auto& part : seen) {
        auto made = inkOnPage(part, drawing.width, drawing.height, plotter);
        const auto under = beneath.of(part);
        made.color = paintOver(part.color, strokes.opacity, under, opacity).color;
        made.beneath = encoded(under);
        made.opacity = opacity;
        if (&part == &seen.front())
            ink = std::move(made);
        else if (!made.empty())
            ink.parts.push_back(std::move(made));
    }
    ink.name = "ink " + hexColor(encoded(strokes.color));
    return ink;
}

PageDot placedDot(const render::Dot& dot, const SeenDot& seen, const glm::vec3& beneath,
                  const PageLayout& layout, double scale) {
    const auto paint = paintOver(seen.color, dot.opacity, beneath);
    PageDot placed{layout.x(dot.x), layout.y(dot.y), scale * dot.radius,
                   paint.opacity,   paint.color,     encoded(beneath)};
    for (const auto& corner : seen.outline) placed.outline.push_back(scale * corner);
    return placed;
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
    for (std::size_t i = drawing.strokes.size(); i-- > 0;)
        placed.inks.push_back(inkOf(drawing, i, page.plotter));
    const double scale = radiusScale(drawing.dots, page, placed.layout);
    const Beneath beneath(drawing);
    const PictureSize size{drawing.width, drawing.height};
    for (const auto& pen : pensOf(drawing.dots, page.plotter)) {
        PageLayer layer{pen.name, {}};
        for (const auto index : pen.dots) {
            const auto& dot = drawing.dots[index];
            for (const auto& seen : seenOf(dot, sightOf(drawing, drawing.strokes.size()), size, page.plotter))
                layer.dots.push_back(placedDot(dot, seen, beneath.at(dot.x, dot.y), placed.layout, scale));
        }
        if (page.plotter) orderForPen(layer.dots);
        placed.layers.push_back(std::move(layer));
    }
    return placed;
}

Result<std::vector<std::uint8_t>> drawVector(const VectorDrawing& drawing, const Page& page) {
    const auto placed = placeOnPage(drawing, page);
    return page.format == proto::Page::SVG ? writeSvg(placed) : writeCairo(placed, page.format);
}

}  // namespace mote::server
