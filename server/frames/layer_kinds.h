// SPDX-License-Identifier: GPL-3.0-or-later
//
// These functions make a layer of each kind part of a scene. A kind is a file (particles_layer.cpp,
// hybrid_layer.cpp, ...) with the overloads for its style; scene_maker.cpp chooses among them,
// and nobody else asks for a layer's kind. Used by the thread that renders.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "protocol/base/error.h"
#include "protocol/scene/view.h"
#include "server/data/step_source.h"
#include "server/frames/dot_maker.h"
#include "server/frames/render_schedule.h"
#include "server/render/layers/scene.h"

namespace mote::server {

/// A layer, and what its part of the picture is made from. All that it refers to outlives the part.
struct LayerRequest {
    const View& view;
    const Layer& layer;
    const RenderJob& job;
    StepSource& data;
    DrawnPhotographs& photographs;
};

/// Puts what a layer draws into a scene in which it has the place `index`; from what is remembered of it to
/// what is remembered for the next picture.
using LayerPart =
    std::function<DotHistory::Layer(render::Scene& scene, std::size_t index, DotHistory::Layer before)>;

/// Asks for a layer's data. Empty where they are on their way: the picture waits. Errors: of StepSource;
/// invalidArgument, unsupported (a dataset of another kind), resourceExhausted.
Result<LayerPart> partOf(const proto::ParticlesStyle& style, const LayerRequest& asked);
Result<LayerPart> partOf(const proto::HybridStyle& style, const LayerRequest& asked);
Result<LayerPart> partOf(const StippleStyle& style, const LayerRequest& asked);
Result<LayerPart> partOf(const proto::InkStyle& style, const LayerRequest& asked);
Result<LayerPart> partOf(const MeshStyle& style, const LayerRequest& asked);
Result<LayerPart> partOf(const proto::ImageStyle& style, const LayerRequest& asked);

/// A layer in one of its steps, to be looked for.
struct ShownLayer {
    const Layer& layer;
    std::uint32_t step;
    bool onLight;  ///< the background is light
};

/// Tells a camera all places that a layer's data and curves show. False where data are on their way. Errors:
/// of StepSource.
Result<bool> shownOf(const proto::ParticlesStyle& style, const ShownLayer& shown, StepSource& data,
                     CameraFit& fit);
Result<bool> shownOf(const proto::HybridStyle& style, const ShownLayer& shown, StepSource& data,
                     CameraFit& fit);
Result<bool> shownOf(const StippleStyle& style, const ShownLayer& shown, StepSource& data, CameraFit& fit);
Result<bool> shownOf(const proto::InkStyle& style, const ShownLayer& shown, StepSource& data, CameraFit& fit);
Result<bool> shownOf(const MeshStyle& style, const ShownLayer& shown, StepSource& data, CameraFit& fit);
Result<bool> shownOf(const proto::ImageStyle& style, const ShownLayer& shown, StepSource& data,
                     CameraFit& fit);

/// What several kinds of layers draw alike: a mesh, without what clips cut away; a hybrid volume. As partOf.
Result<LayerPart> meshPart(const LayerRequest& asked, const HalfSpaces& clips = {});
Result<LayerPart> hybridPart(HybridRepresentation representation, const LayerRequest& asked);

/// The plane hierarchy of a layer that stipples a picture; null where it is on its way. Errors: as partOf.
Result<std::shared_ptr<const render::PlaneTiles>> planeOf(const Layer& layer, StepSource& data);
/// Dots of a moving view are placed and weighed; at rest they are made to fit.
render::PhotographEffort effortOf(Stage stage);

}  // namespace mote::server
