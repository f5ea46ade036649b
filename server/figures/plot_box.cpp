// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/plot_box.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>

#include "server/figures/box_edges.h"
#include "server/figures/quantity_text.h"
#include "server/figures/ticks.h"

namespace mote::server {
namespace {

constexpr int mostBoxTicks = 7;
constexpr double leastLength = 4.0;  // em, of an edge that gets labels
constexpr double behind = 0.4;       // opacity of edges that lie behind the plot
constexpr double samePlace = 0.5;    // pixels

/// An edge with its ticks and the labels that have room.
struct LabelledEdge {
    std::vector<LineMark> ticks;
    std::vector<TextMark> labels;
    std::optional<TextMark> title;
    double worth = 0.0;  ///< of several, the greatest is drawn
};

/// Where a text of an axis stands, so far out from the edge.
glm::dvec2 anchorFor(const glm::dvec2& out) {
    // The whole way to a side as soon as it is mostly that way: labels beside an edge line up.
    const glm::dvec2 way = glm::clamp(1.4 * out, -1.0, 1.0);
    return 0.5 * (1.0 - way);
}

class AxisLabels {
  public:
    AxisLabels(const PlotBox::Axis& axis, const BoxEdge& edge, const glm::dvec2& middle,
               const Projection& projection, const AnnotationRoom& room)
        : axis_(axis), edge_(edge), projection_(projection), room_(room), look_(room.look()) {
        const glm::dvec2 from = pixel(edge.from), to = pixel(edge.to);
        length_ = glm::length(to - from);
        if (!(length_ >= leastLength * look_.font)) return;
        way_ = (to - from) / length_;
        out_ = glm::dvec2(way_.y, -way_.x);
        if (glm::dot(out_, from - middle) < 0.0) out_ = -out_;
    }

    std::optional<LabelledEdge> make() const {
        if (!(length_ >= leastLength * look_.font)) return std::nullopt;
        for (int most = mostBoxTicks; most > 1; --most) {
            const auto ticks = linearTicks(value(edge_.from), value(edge_.to), axis_.unit, most);
            if (!ticks.ok()) return std::nullopt;
            if (auto made = withTicks(*ticks); made) return made;
        }
        return std::nullopt;
    }

  private:
    glm::dvec2 pixel(double share) const { return projection_.pixel(edge_.at(share)); }
    double value(double share) const { return axis_.min + share * (axis_.max - axis_.min); }
    double shareOf(double value) const { return (value - axis_.min) / (axis_.max - axis_.min); }

    LineMark tickAt(const glm::dvec2& at, double length) const {
        return {{at, at + length * out_}, look_.line, look_.ink};
    }

    /// Nothing where labels of the axis would lie over each other.
    std::optional<LabelledEdge> withTicks(const Ticks& ticks) const {
        LabelledEdge made;
        std::vector<Quad> own;
        for (const double minor : ticks.minor)
            made.ticks.push_back(tickAt(pixel(shareOf(minor)), 0.55 * look_.tick()));
        double reach = 0.0;
        for (const auto& tick : ticks.major) {
            const glm::dvec2 at = pixel(shareOf(tick.value));
            made.ticks.push_back(tickAt(at, look_.tick()));
            const auto label =
                room_.text(tick.label, at + (look_.tick() + look_.gap()) * out_, anchorFor(out_));
            const Quad quad = quadOf(label, room_.typeface());
            const Quad apart = quadOf(Box{boxAround(quad)}.grown(0.2 * look_.font));
            if (std::any_of(own.begin(), own.end(), [&](const Quad& other) { return meet(apart, other); }))
                return std::nullopt;
            own.push_back(quad);
            for (const auto& corner : quad) reach = std::max(reach, glm::dot(corner - at, out_));
            if (room_.free(quad)) made.labels.push_back(label);
        }
        made.title = titleOf(ticks, reach + look_.gap(), own);
        made.worth = static_cast<double>(made.labels.size()) /
                     std::max<double>(1.0, static_cast<double>(ticks.major.size()));
        made.worth += (made.title ? 1.0 : 0.0) + 0.1 * out_.y - 0.05 * out_.x;
        return made;
    }

    /// Along the edge, beyond the labels, where there is room.
    std::optional<TextMark> titleOf(const Ticks& ticks, double away, const std::vector<Quad>& own) const {
        double angle = std::atan2(way_.y, way_.x);
        // Read from below, or, of a steep edge, from the right.
        constexpr double steep = std::numbers::pi / 3.0;
        if (angle > steep) angle -= std::numbers::pi;
        if (angle <= steep - std::numbers::pi) angle += std::numbers::pi;
        const glm::dvec2 up(std::sin(angle), -std::cos(angle));
        const bool above = glm::dot(up, out_) > 0.0;
        const double lift = above ? Typeface::descent * look_.font : 0.0;
        for (const double share : {0.5, 0.35, 0.65, 0.2, 0.8}) {
            const glm::dvec2 at = pixel(edge_.from + share * (edge_.to - edge_.from));
            const auto title = room_.text(ticks.title(quantityText(axis_.name)), at + (away + lift) * out_,
                                          {0.5, above ? 1.0 : 0.0}, angle);
            const Quad quad = quadOf(title, room_.typeface());
            const bool over =
                std::any_of(own.begin(), own.end(), [&](const Quad& other) { return meet(quad, other); });
            if (!over && room_.free(quad)) return title;
        }
        return std::nullopt;
    }

    const PlotBox::Axis& axis_;
    const BoxEdge& edge_;
    const Projection& projection_;
    const AnnotationRoom& room_;
    const PlotLook& look_;
    double length_ = 0.0;  // pixels, of what is in the picture
    glm::dvec2 way_{0.0};  // along the edge
    glm::dvec2 out_{0.0};  // away from the box
};

/// Whether an edge lies where one of the outline does, as the far ones do of a plot seen along an axis.
bool hidden(const BoxEdge& edge, const BoxInPicture& box, const Projection& projection) {
    const auto same = [](const glm::dvec2& a, const glm::dvec2& b) {
        return glm::distance(a, b) < samePlace;
    };
    const auto low = projection.pixel(edge.at(edge.from)), high = projection.pixel(edge.at(edge.to));
    if (same(low, high)) return true;
    return std::any_of(box.edges.begin(), box.edges.end(), [&](const BoxEdge& other) {
        if (other.kind != BoxEdge::Kind::outline || other.axis != edge.axis || other.from >= other.to)
            return false;
        const auto from = projection.pixel(other.at(other.from)), to = projection.pixel(other.at(other.to));
        return (same(low, from) && same(high, to)) || (same(low, to) && same(high, from));
    });
}

void addEdges(const BoxInPicture& box, const Projection& projection, AnnotationRoom& room) {
    for (const auto& edge : box.edges) {
        if (edge.kind == BoxEdge::Kind::front || edge.from >= edge.to) continue;
        const bool outline = edge.kind == BoxEdge::Kind::outline;
        if (!outline && hidden(edge, box, projection)) continue;
        Ink ink = room.look().ink;
        if (!outline) ink.opacity *= behind;
        room.marks().push_back(
            LineMark{{projection.pixel(edge.at(edge.from)), projection.pixel(edge.at(edge.to))},
                     room.look().line,
                     ink});
    }
}

}  // namespace

void addPlotBox(const PlotBox& plot, const View& view, AnnotationRoom& room) {
    const Projection projection(view);
    const auto box = boxInPicture(projection.worldToEye() * plot.transform, projection, room.picture());
    addEdges(box, projection, room);
    if (!box.outlined) return;
    for (int axis = 0; axis < 3; ++axis) {
        std::optional<LabelledEdge> best;
        for (const auto& edge : box.edges) {
            if (edge.axis != axis || edge.kind == BoxEdge::Kind::front || edge.from >= edge.to) continue;
            auto made =
                AxisLabels(plot.axes[static_cast<std::size_t>(axis)], edge, box.middle, projection, room)
                    .make();
            if (!made || made->labels.empty()) continue;
            // Before what lies inside, where the plot may be, whatever lies outside.
            if (edge.kind == BoxEdge::Kind::outline) made->worth += 10.0;
            if (!best || made->worth > best->worth) best = std::move(made);
        }
        if (!best) continue;
        for (auto& tick : best->ticks) room.marks().push_back(std::move(tick));
        for (const auto& label : best->labels) room.put(label);
        if (best->title) room.put(*best->title);
    }
}

}  // namespace mote::server
