// SPDX-License-Identifier: GPL-3.0-or-later
//
// These functions make the dots of stipple layers. What they remember from picture to picture is told apart
// by its data, but keeps none of that in memory. Used by the thread that renders.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/scene/view.h"
#include "server/render/layers/scene.h"
#include "server/render/layers/stipple/photograph.h"
#include "server/render/layers/stipple/soft_points.h"

namespace mote::server {

/// Where one session's soft dots are on their way, and what its ink remembers.
struct DotHistory {
    struct Layer {
        std::weak_ptr<const render::StippleSurface> surface = {};
        render::SoftPoints points = {};
        std::weak_ptr<const void> inked = {};              ///< what the ink drew
        std::shared_ptr<render::InkMemory> ink = nullptr;  ///< of a coherent layer
    };
    std::vector<Layer> layers = {};  ///< as those of the latest view

    /// Whether the latest picture showed all dots where they belong.
    bool settled() const;
};

/// A copy of its own: what is drawn with the one changes nothing in the other.
DotHistory copyOf(const DotHistory& history);

/// The dots of a layer on a surface, in a view; `history`: the layer's own. `onTheWay`: soft dots go one
/// step; otherwise all are where they belong.
render::Dots surfaceDots(const View& view, const Layer& layer,
                         const std::shared_ptr<const render::StippleSurface>& surface, bool onTheWay,
                         DotHistory::Layer& history);

/// The dots of the latest photographs, so that a view in which they stay as they are does not make them
/// again.
class DrawnPhotographs {
  public:
    using Tiles = std::shared_ptr<const render::PlaneTiles>;
    using Image = std::shared_ptr<const render::PixelMap>;

    std::shared_ptr<const render::Dots> dots(const Tiles& tiles, const Image& image, const View& view,
                                             const StippleStyle& style,
                                             const render::PhotographEffort& effort);

  private:
    struct Drawn {
        std::weak_ptr<const render::PlaneTiles> tiles;
        std::weak_ptr<const render::PixelMap> image;
        std::uint32_t width, height;
        StippleStyle style;
        render::PhotographEffort effort;
        std::shared_ptr<const render::Dots> dots;
    };
    std::list<Drawn> drawn_;  // the latest first
};

/// Whether a view may ask for so many dots on the plane. Errors: resourceExhausted.
Status checkDots(const View& view, const StippleStyle& style);

/// Puts dots of a layer, with its opacity, behind those that are in a scene: of one on the screen those that
/// its clips leave.
void addDots(render::Scene& scene, const render::Dots& dots, const Layer& layer);

}  // namespace mote::server
