// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/scene_maker.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/common.hpp>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "protocol/scene/bounds.h"
#include "protocol/scene/camera.h"
#include "protocol/scene/dataset.h"
#include "protocol/scene/space/metres.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/view_message.h"
#include "server/frames/layer_kinds.h"

namespace mote::server {
namespace {

/// A layer of which there is nothing: what it would be drawn from must exist, but is not asked for.
Result<LayerPart> nothingOf(const Layer& layer, StepSource& data) {
    MOTE_RETURN_IF_ERROR(data.dataset(layer.dataset));
    const StippleStyle* const stipple = layer.stipple();
    if (stipple != nullptr && !stipple->image().empty()) {
        const auto image = data.dataset(stipple->image());
        if (!image.ok()) return Error{image.error().code, "stipple.image", image.error().message};
    }
    return LayerPart([](render::Scene&, std::size_t, const auto&) { return DotHistory::Layer(); });
}

}  // namespace

Status checkTowards(const View& view, StepSource& data) {
    for (std::size_t i = 0; i < view.layers.size(); ++i) {
        const auto& [dataset, towards] = std::tie(view.layers[i].dataset, view.layers[i].towards);
        if (!towards) continue;
        const auto found = data.dataset(dataset);
        if (!found.ok()) return inLayer(i, found.error());
        // That a dataset is of another kind, without steps, is said when it is drawn.
        const int steps = stepCount(*found->manifest);
        if (steps == 0 || towards->step < static_cast<std::uint32_t>(steps)) continue;
        return inLayer(i, {ErrorCode::notFound, "towards.step",
                           fmt::format("\"{}\" has {} steps, numbered from 0; there is no step {}", dataset,
                                       steps, towards->step)});
    }
    return success();
}

namespace {

/// False where its data are on their way.
Result<bool> showLayer(const Layer& layer, bool onLight, StepSource& data, CameraFit& fit) {
    fit.enter(layer.transform, layer.clips());
    const auto show = [&](std::uint32_t step) {
        return std::visit(
            [&](const auto& style) {
                return shownOf(style, ShownLayer{layer, step, onLight}, data, fit);
            },
            layer.style);
    };
    MOTE_ASSIGN_OR_RETURN(bool ready, show(layer.step));
    if (layer.towards && layer.towards->step != layer.step) {
        MOTE_ASSIGN_OR_RETURN(const bool other, show(layer.towards->step));
        ready = ready && other;
    }
    if (!ready || fit.inLayer()) return ready;
    // Nothing of it is seen: it is looked for where it would be.
    MOTE_ASSIGN_OR_RETURN(const auto entry, data.dataset(layer.dataset));
    fit.add(datasetBounds(*entry.manifest));
    return true;
}

/// Axes stand a little off what they are the axes of.
Bounds besideAxes(const Bounds& shown) {
    constexpr double share = 0.03, least = 1e-3;
    const glm::dvec3 off = glm::max(share * shown.size(), glm::dvec3(least));
    return {glm::max(shown.min - off, plotBounds.min), glm::min(shown.max + off, plotBounds.max)};
}

/// With boxes around plots that annotations draw.
void addAxes(const View& view, std::size_t index, std::optional<Bounds>& shown, CameraFit& fit) {
    const Layer& layer = view.layers[index];
    if (!shown || !layer.particles() || !view.annotations || !view.annotations->axes()) return;
    shown = besideAxes(*shown);
    fit.enter(layer.transform);
    fit.add(*shown);
}

}  // namespace

Status placeLayers(View& view, StepSource& data) {
    return mote::placeLayers(view, [&](const std::string& name, std::uint32_t step) -> Result<glm::dmat4> {
        MOTE_ASSIGN_OR_RETURN(const auto entry, data.dataset(name));
        return placeInMetres(*entry.manifest, step, name);
    });
}

Result<bool> fitLayers(View& view, StepSource& data) {
    if (!view.cameraFitted) return true;
    std::optional<CameraFit> fit;
    bool ready = true;
    view.shown.assign(view.layers.size(), std::nullopt);
    for (std::size_t i = 0; i < view.layers.size(); ++i) {
        const Layer& layer = view.layers[i];
        if (!isFitted(layer)) continue;
        const auto found = data.dataset(layer.dataset);
        if (!found.ok()) return inLayer(i, found.error());
        if (!fit)
            fit.emplace(outlookOf(datasetOutlook(*found->manifest), layer.transform), view.aspect(),
                        fitMargin(view));
        const auto shown = showLayer(layer, isLight(view.background), data, *fit);
        if (!shown.ok()) return inLayer(i, shown.error());
        ready = *shown && ready;
        view.shown[i] = fit->inLayer();
        addAxes(view, i, view.shown[i], *fit);
    }
    if (fit && ready) view.camera = fit->camera();
    return ready;
}

View besideDots(View view, std::size_t index) {
    const auto dots = view.layers.begin() + static_cast<std::ptrdiff_t>(index);
    const double left = 1.0 - dots->opacity;
    std::for_each(view.layers.begin(), dots, [left](Layer& layer) { layer.opacity *= left; });
    view.layers.erase(left > 0.0 ? dots : view.layers.begin(), dots + 1);
    return view;
}

Result<std::optional<render::Scene>> makeScene(const View& view, const RenderJob& job, StepSource& data,
                                               DrawnPhotographs& photographs, DotHistory& history,
                                               const Admission& admit) {
    std::vector<LayerPart> parts;
    for (const Layer& layer : view.layers) {
        const LayerRequest asked{view, layer, job, data, photographs};
        auto part = layer.opacity > 0.0
                        ? std::visit([&](const auto& style) { return partOf(style, asked); }, layer.style)
                        : nothingOf(layer, data);
        if (!part.ok()) return inLayer(parts.size(), part.error());
        parts.push_back(*std::move(part));
    }
    if (std::any_of(parts.begin(), parts.end(), [](const auto& part) { return !part; }))
        return std::optional<render::Scene>();
    MOTE_ASSIGN_OR_RETURN(const bool admitted, admit());
    if (!admitted) return std::optional<render::Scene>();
    render::Scene scene{view, {}};
    scene.steps.resize(parts.size());
    scene.hybrids.resize(parts.size());
    history.layers.resize(parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i)
        history.layers[i] = parts[i](scene, i, std::move(history.layers[i]));
    return std::optional(std::move(scene));
}

}  // namespace mote::server
