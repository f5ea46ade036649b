// SPDX-License-Identifier: GPL-3.0-or-later
#include <utility>

#include "server/data/load_stipple.h"
#include "server/frames/layer_kinds.h"

namespace mote::server {
namespace {

Result<std::shared_ptr<const render::PixelMap>> imageOf(const StippleStyle& style, StepSource& data) {
    const auto entry = data.dataset(style.image());
    const auto loadable = entry.ok() ? imageLuminance(*entry) : entry.error();
    if (!loadable.ok()) return Error{loadable.error().code, "stipple.image", loadable.error().message};
    return data.get(loadable);
}

Result<LayerPart> photographOf(const StippleStyle& style, const LayerRequest& asked) {
    MOTE_RETURN_IF_ERROR(checkDots(asked.view, style));
    const auto tiles = planeOf(asked.layer, asked.data);
    if (!tiles.ok()) return tiles.error();
    const auto image = imageOf(style, asked.data);
    if (!image.ok()) return image.error();
    if (!*tiles || !*image) return LayerPart();
    return LayerPart([tiles = *tiles, image = *image, &style, &layer = asked.layer,
                      &drawn = asked.photographs,
                      effort = effortOf(asked.job.stage)](render::Scene& scene, std::size_t, const auto&) {
        addDots(scene, *drawn.dots(tiles, image, scene.view, style, effort), layer);
        return DotHistory::Layer();
    });
}

Result<LayerPart> surfaceOf(const LayerRequest& asked) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, asked.data.dataset(asked.layer.dataset));
    const auto surface = asked.data.get(stippleSurface(entry));
    if (!surface.ok()) return surface.error();
    if (!*surface) return LayerPart();
    return LayerPart([surface = *surface, &layer = asked.layer, quick = asked.job.stage == Stage::quick](
                         render::Scene& scene, std::size_t, DotHistory::Layer history) {
        addDots(scene, surfaceDots(scene.view, layer, surface, quick, history), layer);
        return history;
    });
}

}  // namespace

Result<std::shared_ptr<const render::PlaneTiles>> planeOf(const Layer& layer, StepSource& data) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, data.dataset(layer.dataset));
    return data.get(stipplePlane(entry));
}

render::PhotographEffort effortOf(Stage stage) {
    return stage == Stage::exact ? render::finePhotograph : render::quickPhotograph;
}

Result<bool> shownOf(const StippleStyle&, const ShownLayer& shown, StepSource& data, CameraFit& fit) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, data.dataset(shown.layer.dataset));
    MOTE_ASSIGN_OR_RETURN(const auto surface, data.get(stippleSurface(entry)));
    if (!surface) return false;
    const auto& points = surface->replay();
    for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::dvec3 place(points.position(i));
        if (fit.takes(place)) fit.add(place);
    }
    return true;
}

/// Without its data there is nothing to be shown of it: a view in motion waits, too.
Result<LayerPart> partOf(const StippleStyle& style, const LayerRequest& asked) {
    return onPlane(style) ? photographOf(style, asked) : surfaceOf(asked);
}

}  // namespace mote::server
