// SPDX-License-Identifier: GPL-3.0-or-later
//
// The dots of stipple layers on surfaces, and what is remembered of them from picture to picture. Used by the
// thread that renders.
#pragma once

#include <memory>
#include <vector>

#include "protocol/scene/error.h"
#include "protocol/scene/view.h"
#include "server/data/step_source.h"
#include "server/render/layers/stipple/soft_points.h"
#include "server/render/plan/dot.h"

namespace mote::server {

/// Of one session: where soft dots are on their way.
struct DotHistory {
    struct Layer {
        std::shared_ptr<const render::StippleSurface> surface = {};
        render::SoftPoints points = {};
    };
    std::vector<Layer> layers = {};  ///< as those of the latest view

    /// Whether the latest picture showed all dots where they belong.
    bool settled() const;
};

/// Fits the camera of a view that came without one to the plots and surfaces of its layers. Errors: as
/// StepSource::surface, with the layer's place.
Status fitLayers(View& view, StepSource& source);

/// The dots of a layer on a surface, in a view; `history`: the layer's own. `onTheWay`: soft dots go one
/// step; otherwise all are where they belong. Errors: as StepSource::surface.
Result<render::Dots> surfaceDots(const View& view, const Layer& layer, StepSource& source, bool onTheWay,
                                 DotHistory::Layer& history);

}  // namespace mote::server
