// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/annotate.h"

#include <algorithm>
#include <glm/common.hpp>

#include "protocol/quantity/plot_axes.h"
#include "protocol/scene/mote_check.h"
#include "protocol/scene/srgb.h"
#include "server/figures/annotation_bars.h"
#include "server/figures/annotation_room.h"
#include "server/figures/annotation_words.h"
#include "server/figures/plot_box.h"

namespace mote::server {
namespace {

constexpr double haloOpacity = 0.7;

PlotLook lookOf(const View& view) {
    const Annotations& annotations = *view.annotations;
    const glm::dvec3 standsOut(isLight(view.background) ? 0.0 : 1.0);
    const glm::dvec3 color = annotations.color.value_or(standsOut);
    PlotLook look;
    look.font = annotations.fontPixels(view.width, view.height, view.scale);
    look.line = 0.075 * look.font;
    look.ink = {linearToSrgb(glm::clamp(color, 0.0, 1.0))};
    look.paper = linearToSrgb(glm::clamp(view.background, 0.0, 1.0));
    look.halo = {look.paper, haloOpacity};
    return look;
}

/// One for each plot that is seen, however many layers show it: a film shows two steps at once.
std::vector<PlotBox> boxesOf(const View& view, const std::vector<LayerFacts>& layers) {
    std::vector<PlotBox> boxes;
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const Layer& layer = view.layers[i];
        const bool plot =
            layers[i].manifest != nullptr && layers[i].manifest->particles().axes_size() >= axesOfPlot;
        if (!plot || !(layer.opacity > 0.0)) continue;
        PlotBox box{{}, layer.transform};
        for (int axis = 0; axis < 3; ++axis) {
            const auto& of = axisOf(layers[i].manifest->particles(), axis, layer.step);
            box.axes[static_cast<std::size_t>(axis)] = {of.name(), of.unit(), of.min(), of.max()};
        }
        if (std::find(boxes.begin(), boxes.end(), box) == boxes.end()) boxes.push_back(std::move(box));
    }
    return boxes;
}

}  // namespace

Marks annotate(const View& view, const std::vector<LayerFacts>& layers) {
    MOTE_CHECK(view.annotations && layers.size() == view.layers.size());
    const Annotations& annotations = *view.annotations;
    AnnotationRoom room(view.width, view.height, lookOf(view));
    // What has its own place goes first; ticks take what is left.
    if (!annotations.title.empty()) addTitle(annotations.title, room);
    if (annotations.labels) addWords(view, layers, room);
    if (annotations.colorBar) addColorBars(view, layers, room);
    if (annotations.scaleBar) addScaleBar(view, layers, room);
    if (annotations.axes) {
        for (const auto& box : boxesOf(view, layers)) addPlotBox(box, view, room);
    }
    return std::move(room.marks());
}

}  // namespace mote::server
