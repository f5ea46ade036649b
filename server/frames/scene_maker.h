// SPDX-License-Identifier: GPL-3.0-or-later
//
// These functions turn a view into its scene, with the data of its layers. Used by the thread that renders.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/scene/view.h"
#include "server/data/step_source.h"
#include "server/frames/dot_maker.h"
#include "server/frames/render_schedule.h"
#include "server/render/layers/scene.h"

namespace mote::server {

/// Where an error of a layer belongs: a field gets its place in the view, a file keeps its own.
inline Error inLayer(std::size_t index, const Error& error) {
    const bool field = error.where.find('/') == std::string::npos;
    return field ? error.within("layers[" + std::to_string(index) + "]") : error;
}

/// Whether the steps that layers are on their way to are there, at whatever share. Errors: notFound, with the
/// layer's place.
Status checkTowards(const View& view, StepSource& data);

/// Puts the layers of a view in metres where they lie. Errors: as mote::placeLayers(); notFound.
Status placeLayers(View& view, StepSource& data);

/// Fits the camera of a view that came without one to what its layers show, of a layer between two steps in
/// both of them, and tells their boxes in View::shown. False where data are on their way: all that is missing
/// was asked for. Errors: of StepSource, with the layer's place.
Result<bool> fitLayers(View& view, StepSource& data);

/// What axes stand around: the boxes of layers, and what they were found of. A value.
struct PlotBoxes {
    std::vector<Layer> layers = {};
    bool onLight = false;                                                ///< the background is light
    std::vector<std::shared_ptr<const proto::Manifest>> manifests = {};  ///< of the layers' datasets
    std::vector<std::optional<Bounds>> shown = {};                       ///< as View::shown

    /// Whether these layers have the boxes of those.
    bool isOfThoseOf(const PlotBoxes& other) const {
        return onLight == other.onLight && manifests == other.manifests && layers == other.layers;
    }
};

/// Tells the boxes that the axes of a view stand around, whether its camera was fitted (fitLayers()) or said:
/// a hand that takes a fitted view changes no box. `known`: those of the picture before, of which a picture
/// in motion has those whose data are on their way; of another they are waited for. Errors: as fitLayers().
Result<bool> boxPlots(View& view, Stage stage, StepSource& data, PlotBoxes& known);

/// What is seen beside the dots of layer `index`, which stipples those before it: what it leaves of them, and
/// those after it.
View besideDots(View view, std::size_t index);

/// Whether a picture may be made; asked when its data are there and nothing large was made.
using Admission = std::function<Result<bool>()>;

/// The scene of a view, with the data of each of its layers; nothing where some are on their way: all that is
/// missing was asked for; or where it is not admitted. `history` changes with a scene alone. Errors: as
/// partOf (layer_kinds.h), with the layer's place, and of the admission.
Result<std::optional<render::Scene>> makeScene(const View& view, const RenderJob& job, StepSource& data,
                                               DrawnPhotographs& photographs, DotHistory& history,
                                               const Admission& admit);

}  // namespace mote::server
