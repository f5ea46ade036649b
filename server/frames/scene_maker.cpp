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

/// What of a layer is seen, in its space; not ready where its data are on their way.
struct Seen {
    bool ready = true;
    std::optional<Bounds> box = {};
};

/// Between two steps a camera sees both, and the box is as far on its way as the layer.
Result<Seen> showLayer(const Layer& layer, bool onLight, StepSource& data, CameraFit& fit) {
    const auto show = [&](std::uint32_t step) -> Result<Seen> {
        fit.enter(layer.transform, layer.clips());
        MOTE_ASSIGN_OR_RETURN(const bool ready,
                              std::visit(
                                  [&](const auto& style) {
                                      return shownOf(style, ShownLayer{layer, step, onLight}, data, fit);
                                  },
                                  layer.style));
        return Seen{ready, fit.inLayer()};
    };
    MOTE_ASSIGN_OR_RETURN(auto seen, show(layer.step));
    if (layer.towards && layer.towards->step != layer.step) {
        MOTE_ASSIGN_OR_RETURN(const auto other, show(layer.towards->step));
        const double share = layer.towards->share;
        seen.ready = seen.ready && other.ready;
        if (seen.box && other.box)
            seen.box = {glm::mix(seen.box->min, other.box->min, share),
                        glm::mix(seen.box->max, other.box->max, share)};
        else if (other.box)
            seen.box = other.box;
    }
    if (!seen.ready || seen.box) return seen;
    // Nothing of it is seen: it is looked for where it would be.
    MOTE_ASSIGN_OR_RETURN(const auto entry, data.dataset(layer.dataset));
    fit.add(datasetBounds(*entry.manifest));
    seen.box = fit.inLayer();
    return seen;
}

/// Axes stand a little off what they are the axes of.
Bounds besideAxes(const Bounds& shown) {
    constexpr double share = 0.03, least = 1e-3;
    const glm::dvec3 off = glm::max(share * shown.size(), glm::dvec3(least));
    return {glm::max(shown.min - off, plotBounds.min), glm::min(shown.max + off, plotBounds.max)};
}

bool hasAxes(const View& view) {
    return view.annotations && view.annotations->axes();
}

bool standAroundPlots(const View& view) {
    return hasAxes(view) && view.annotations->axes_around() == "plot";
}

/// With boxes around plots that annotations draw.
void addAxes(const View& view, std::size_t index, std::optional<Bounds>& shown, CameraFit& fit) {
    const Layer& layer = view.layers[index];
    if (!shown || !layer.particles() || !hasAxes(view)) return;
    shown = standAroundPlots(view) ? plotBounds : besideAxes(*shown);
    fit.enter(layer.transform);
    fit.add(*shown);
}

/// Fits a camera to all layers, or to plots alone, and tells the boxes of these layers.
Result<bool> showLayers(View& view, bool plotsAlone, StepSource& data, std::optional<CameraFit>& fit) {
    bool ready = true;
    view.shown.assign(view.layers.size(), std::nullopt);
    for (std::size_t i = 0; i < view.layers.size(); ++i) {
        const Layer& layer = view.layers[i];
        if (!isFitted(layer)) continue;
        const auto found = data.dataset(layer.dataset);
        if (!found.ok()) return inLayer(i, found.error());
        if (plotsAlone && !found->manifest->has_particles()) continue;
        if (!fit)
            fit.emplace(outlookOf(datasetOutlook(*found->manifest), layer.transform), fittedAspect(view),
                        fitMargin(view).y);
        const auto seen = showLayer(layer, isLight(view.background), data, *fit);
        if (!seen.ok()) return inLayer(i, seen.error());
        ready = seen->ready && ready;
        view.shown[i] = seen->box;
        addAxes(view, i, view.shown[i], *fit);
    }
    return ready;
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
    MOTE_ASSIGN_OR_RETURN(const bool ready, showLayers(view, false, data, fit));
    if (fit && ready) view.camera = fit->camera();
    return ready;
}

Result<bool> boxPlots(View& view, Stage stage, StepSource& data, PlotBoxes& known) {
    if (!hasAxes(view)) return true;
    if (standAroundPlots(view)) {
        view.shown.assign(view.layers.size(), std::nullopt);
        return true;
    }
    PlotBoxes now{view.layers, isLight(view.background), {}, {}};
    for (std::size_t i = 0; i < view.layers.size(); ++i) {
        const auto found = data.dataset(view.layers[i].dataset);
        if (!found.ok()) return inLayer(i, found.error());
        now.manifests.push_back(found->manifest);
    }
    if (now.isOfThoseOf(known)) {
        view.shown = known.shown;
        return true;
    }
    if (!view.cameraFitted) {
        std::optional<CameraFit> unseen;
        MOTE_ASSIGN_OR_RETURN(const bool ready, showLayers(view, true, data, unseen));
        if (!ready && stage != Stage::quick) return false;
        if (!ready) {
            view.shown = known.shown;
            view.shown.resize(view.layers.size());
            return true;
        }
    }
    now.shown = view.shown;
    known = std::move(now);
    return true;
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
    render::Scene scene{view, std::vector<render::LayerData>(parts.size())};
    history.layers.resize(parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i)
        history.layers[i] = parts[i](scene, i, std::move(history.layers[i]));
    return std::optional(std::move(scene));
}

}  // namespace mote::server
