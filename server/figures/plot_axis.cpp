// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/plot_axis.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "protocol/base/utf8.h"
#include "protocol/scene/srgb.h"

namespace mote::server {
namespace {

constexpr int mostTicks = 8;
constexpr double minorTick = 0.55;  // of a tick's length

bool across(Side side) {
    return side == Side::bottom || side == Side::top;
}

/// Outwards.
glm::dvec2 wayOut(Side side) {
    if (side == Side::bottom) return {0.0, 1.0};
    if (side == Side::top) return {0.0, -1.0};
    return {side == Side::left ? -1.0 : 1.0, 0.0};
}

double widthOf(const RichText& text, const PlotLook& look, const Typeface& typeface) {
    return typeface.layOut(text, look.font).width;
}

/// Whether the labels stand apart, and none reaches far beyond the axis' ends.
bool fits(const PlotAxis& axis, double length, const PlotLook& look, const Typeface& typeface) {
    double before = -1e300;
    std::vector<std::pair<double, double>> places;
    for (const auto& tick : axis.ticks.major) {
        const double at = axis.scale.share(tick.value) * length;
        const double half =
            0.5 * (across(axis.side) ? widthOf(tick.label, look, typeface) : Typeface::ascent * look.font);
        places.emplace_back(at - half, at + half);
    }
    std::sort(places.begin(), places.end());
    const double apart = across(axis.side) ? 0.8 * look.font : 0.45 * look.font;
    for (const auto& [from, to] : places) {
        if (from < before + apart) return false;
        before = to;
    }
    return true;
}

double labelRoom(const PlotAxis& axis, const PlotLook& look, const Typeface& typeface) {
    if (!axis.labels || axis.ticks.major.empty()) return 0.0;
    if (across(axis.side)) return Typeface::ascent * look.font;
    double widest = 0.0;
    for (const auto& tick : axis.ticks.major) widest = std::max(widest, widthOf(tick.label, look, typeface));
    return widest;
}

void addTick(const glm::dvec2& at, Side side, double length, const PlotLook& look, Marks& marks) {
    marks.push_back(LineMark{{at, at + length * wayOut(side)}, look.line, look.ink});
}

}  // namespace

void addColorBar(const Box& box, const PlotAxis& axis, const std::function<glm::dvec3(double)>& color,
                 const PlotLook& look, const Typeface& typeface, Marks& marks) {
    constexpr std::uint32_t shades = 256;
    ImageMark image{box, 1, shades, {}};
    for (std::uint32_t i = 0; i < shades; ++i) {
        const auto shade = linearToSrgb(glm::clamp(color((shades - i - 0.5) / shades), 0.0, 1.0));
        for (int c = 0; c < 3; ++c)
            image.rgba.push_back(static_cast<std::uint8_t>(std::lround(shade[c] * 255.0)));
        image.rgba.push_back(255);
    }
    marks.push_back(std::move(image));
    addFrame(box, look, marks);
    addAxis(axis, box, look, typeface, marks);
}

double AxisScale::share(double value) const {
    if (logarithmic) return std::log(value / low) / std::log(high / low);
    // In halves: their difference may be more than a double holds.
    return (value / 2.0 - low / 2.0) / (high / 2.0 - low / 2.0);
}

double PlotAxis::place(double value, const Box& frame) const {
    const double share = scale.share(value);
    return across(side) ? frame.low.x + share * frame.size().x : frame.high.y - share * frame.size().y;
}

Result<PlotAxis> makeAxis(Side side, AxisScale scale, std::string_view unit, const RichText& name,
                          double length, const PlotLook& look, const Typeface& typeface) {
    if (scale.low == scale.high) {
        const double apart = scale.low == 0.0 ? 1.0 : 0.1 * std::abs(scale.low);
        if (scale.logarithmic)
            scale = {scale.low / 2.0, scale.low * 2.0, true};
        else
            scale = {scale.low - apart, scale.low + apart, false};
    }
    PlotAxis axis{side, scale, {}, {}};
    for (int most = mostTicks; most > 0; --most) {
        MOTE_ASSIGN_OR_RETURN(axis.ticks, scale.logarithmic ? logTicks(scale.low, scale.high, unit, most)
                                                            : linearTicks(scale.low, scale.high, unit, most));
        if (fits(axis, length, look, typeface)) break;
    }
    axis.title = axis.ticks.title(name);
    return axis;
}

double roomOf(const PlotAxis& axis, const PlotLook& look, const Typeface& typeface) {
    double room = look.tick();
    if (const double labels = labelRoom(axis, look, typeface); labels > 0.0) room += look.gap() + labels;
    if (!axis.title.empty()) room += 1.5 * look.gap() + (Typeface::ascent + Typeface::descent) * look.font;
    return room;
}

void addAxis(const PlotAxis& axis, const Box& frame, const PlotLook& look, const Typeface& typeface,
             Marks& marks) {
    const glm::dvec2 out = wayOut(axis.side);
    const bool horizontal = across(axis.side);
    const double edge = axis.side == Side::bottom ? frame.high.y
                        : axis.side == Side::top  ? frame.low.y
                        : axis.side == Side::left ? frame.low.x
                                                  : frame.high.x;
    const auto at = [&](double value) {
        const double along = axis.place(value, frame);
        return horizontal ? glm::dvec2(along, edge) : glm::dvec2(edge, along);
    };
    for (const double value : axis.ticks.minor)
        addTick(at(value), axis.side, minorTick * look.tick(), look, marks);
    for (const auto& tick : axis.ticks.major) {
        addTick(at(tick.value), axis.side, look.tick(), look, marks);
        if (!axis.labels) continue;
        const double away = look.tick() + look.gap();
        // From the side that it stands on; in the middle along the axis.
        const glm::dvec2 anchor = 0.5 * (1.0 - out);
        marks.push_back(
            TextMark{tick.label, at(tick.value) + away * out, look.font, anchor, 0.0, look.ink, look.halo});
    }
    if (axis.title.empty()) return;
    const double room = roomOf(axis, look, typeface);
    const double away = horizontal && axis.side == Side::bottom ? room - Typeface::descent * look.font
                                                                : room - Typeface::ascent * look.font;
    const double length = horizontal ? frame.size().x : frame.size().y;
    const auto title = shortened(axis.title, look.font, std::max(length, 6.0 * look.font), typeface);
    if (horizontal) {
        const double y = axis.side == Side::bottom ? edge + away : edge - away + 0.0;
        marks.push_back(
            TextMark{title, {frame.center().x, y}, look.font, {0.5, 1.0}, 0.0, look.ink, look.halo});
    } else if (axis.side == Side::left) {
        marks.push_back(TextMark{title,
                                 {edge - away, frame.center().y},
                                 look.font,
                                 {0.5, 1.0},
                                 -0.5 * std::numbers::pi,
                                 look.ink,
                                 look.halo});
    } else {
        // Read from the same side as that of the left axis.
        marks.push_back(TextMark{title,
                                 {edge + room - Typeface::descent * look.font, frame.center().y},
                                 look.font,
                                 {0.5, 1.0},
                                 -0.5 * std::numbers::pi,
                                 look.ink,
                                 look.halo});
    }
}

void addFrame(const Box& frame, const PlotLook& look, Marks& marks) {
    marks.push_back(
        LineMark{{frame.low, {frame.high.x, frame.low.y}, frame.high, {frame.low.x, frame.high.y}},
                 look.line,
                 look.ink,
                 true});
}

RichText shortened(RichText text, double size, double width, const Typeface& typeface) {
    if (typeface.layOut(text, size).width <= width) return text;
    text.push_back({"\u2026", false, Script::normal});
    while (text.size() > 1 && typeface.layOut(text, size).width > width) {
        auto& last = text[text.size() - 2].text;
        // The last character goes, with all of its bytes.
        while (!last.empty() && (static_cast<unsigned char>(last.back()) & 0xc0U) == 0x80U) last.pop_back();
        if (!last.empty()) last.pop_back();
        if (last.empty()) text.erase(text.end() - 2);
    }
    return text;
}

}  // namespace mote::server
