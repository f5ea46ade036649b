// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/annotation_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "protocol/scene/dataset.h"
#include "protocol/scene/mix.h"
#include "server/figures/quantity_text.h"

namespace mote::server {
namespace {

constexpr double edgeMargin = 0.8;  // em, from the picture's edges
constexpr double lineHeight = 1.4;  // em
constexpr double titleSize = 1.25;  // of the font's

/// Words one after another with a gap.
RichText joined(const std::vector<RichText>& parts) {
    RichText line;
    for (const auto& part : parts) {
        if (part.empty()) continue;
        if (!line.empty()) line = line + upright("   ");
        line = line + part;
    }
    return line;
}

/// "t = 12.34 ns"; nothing if the source knows no time.
RichText timeText(double time) {
    if (!std::isfinite(time)) return {};
    const int prefix = prefixPower("s", std::abs(time));
    const double shown = time / std::pow(10.0, prefix);
    return italic("t") + upright(" = " + withMinusSign(fmt::format("{:.4g}", shown)) + "\u2009") +
           unitText("s", prefix);
}

/// Of a layer between steps the nearer one is its own; particles that nobody can follow do not move.
RichText stepText(const Layer& layer, const proto::Manifest& manifest) {
    const int steps = stepCount(manifest);
    if (steps < 2) return {};
    if (!layer.towards) return upright(fmt::format("step {} of {}", layer.step, steps - 1));
    const auto [first, last] = std::minmax(layer.step, layer.towards->step);
    const double share = first == layer.step ? layer.towards->share : 1.0 - layer.towards->share;
    const bool still = manifest.kind() == "particles" && !manifest.particles().ids();
    return upright(fmt::format("step {} to {} ({:.0f}%{}) of {}", first, last, 100.0 * share,
                               still ? ", dissolving" : "", steps - 1));
}

RichText timeOf(const Layer& layer, const proto::Manifest& manifest) {
    const auto& steps = manifest.particles().steps();
    const auto there = [&](std::uint32_t step) { return static_cast<int>(step) < steps.size(); };
    if (!there(layer.step) || (layer.towards && !there(layer.towards->step))) return {};
    const bool known =
        std::any_of(steps.begin(), steps.end(), [](const auto& step) { return step.time() != 0.0; });
    if (!known) return {};
    const double time = steps[static_cast<int>(layer.step)].time();
    if (!layer.towards) return timeText(time);
    return timeText(mix(time, steps[static_cast<int>(layer.towards->step)].time(), layer.towards->share));
}

RichText countOf(const Layer& layer, const LayerFacts& facts) {
    const auto& steps = facts.manifest->particles().steps();
    if (static_cast<int>(layer.step) >= steps.size()) return {};
    const auto all = groupedNumber(steps[static_cast<int>(layer.step)].particles());
    const auto of = [&](std::uint64_t some, const char* what) {
        return upright(fmt::format("{} of {} particles{}", groupedNumber(some), all, what));
    };
    std::vector<RichText> parts;
    if (facts.chosen) parts.push_back(of(*facts.chosen, ""));
    if (facts.highlighted) parts.push_back(of(*facts.highlighted, " highlighted"));
    if (parts.empty()) parts.push_back(upright(all + " particles"));
    if (const auto& species = facts.manifest->particles().species(); !species.empty())
        parts.push_back(upright(species));
    return joined(parts);
}

}  // namespace

std::string groupedNumber(std::uint64_t number) {
    std::string digits = fmt::to_string(number);
    if (number < 10000) return digits;
    for (std::size_t at = digits.size() - 3; at > 0 && at<digits.size(); at = at> 3 ? at - 3 : 0)
        digits.insert(at, "\u2009");
    return digits;
}

void addTitle(const std::string& title, AnnotationRoom& room) {
    const auto& look = room.look();
    const double font = titleSize * look.font, width = room.picture().size().x - 2.0 * edgeMargin * look.font;
    auto text = room.text(shortened(upright(title), font, width, room.typeface()),
                          {room.picture().center().x, edgeMargin * look.font}, {0.5, 0.0});
    text.size = font;
    if (room.isFree(text)) room.put(text);
}

void addWords(const View& view, const std::vector<LayerFacts>& layers, AnnotationRoom& room) {
    const auto& look = room.look();
    std::vector<RichText> lines;
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const Layer& layer = view.layers[i];
        if (layers[i].manifest == nullptr || !(layer.opacity > 0.0)) continue;
        const auto& manifest = *layers[i].manifest;
        const auto line =
            joined({upright(layer.dataset), stepText(layer, manifest), timeOf(layer, manifest)});
        for (const auto& words : {line, countOf(layer, layers[i])}) {
            if (!words.empty() && std::find(lines.begin(), lines.end(), words) == lines.end())
                lines.push_back(words);
        }
    }
    double y = edgeMargin * look.font;
    if (!view.annotations->title().empty()) y += titleSize * lineHeight * look.font;
    const double width = room.picture().size().x - 2.0 * edgeMargin * look.font;
    for (auto& line : lines) {
        const auto text = room.text(shortened(std::move(line), look.font, width, room.typeface()),
                                    {edgeMargin * look.font, y}, {0.0, 0.0});
        if (!room.isFree(text)) return;
        room.put(text);
        y += lineHeight * look.font;
    }
}

}  // namespace mote::server
