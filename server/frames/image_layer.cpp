// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/load_image.h"
#include "server/frames/layer_kinds.h"

namespace mote::server {

/// Without the image there is nothing to be shown of it: a view in motion waits, too.
Result<LayerPart> partOf(const proto::ImageStyle&, const LayerRequest& asked) {
    MOTE_ASSIGN_OR_RETURN(const auto entry, asked.data.dataset(asked.layer.dataset));
    const auto image = asked.data.get(imageColors(entry));
    if (!image.ok()) return image.error();
    if (!*image) return LayerPart();
    return LayerPart([image = *image](render::Scene& scene, std::size_t index, const auto&) {
        scene.layers[index].image = image;
        return DotHistory::Layer();
    });
}

/// It has no place that a camera could look for.
Result<bool> shownOf(const proto::ImageStyle&, const ShownLayer&, StepSource&, CameraFit&) {
    return true;
}

}  // namespace mote::server
