// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/dot_maker.h"

#include <fmt/format.h>

#include <algorithm>

#include "protocol/base/most_recent.h"
#include "protocol/scene/fields/facts.h"
#include "protocol/scene/space/picture_plane.h"
#include "server/render/layers/stipple/surface_dots.h"
#include "server/render/layers/stipple/tone.h"

namespace mote::server {
namespace {

constexpr std::size_t mostDrawn = 2;
constexpr double mostDots = 1 << 24;  ///< of one layer; half a GiB while they are made

}  // namespace

bool DotHistory::settled() const {
    return std::all_of(layers.begin(), layers.end(),
                       [](const Layer& layer) { return layer.points.settled(); });
}

DotHistory copyOf(const DotHistory& history) {
    DotHistory copy = history;
    for (auto& layer : copy.layers) {
        if (layer.ink != nullptr) layer.ink = std::make_shared<render::InkMemory>(*layer.ink);
    }
    return copy;
}

render::Dots surfaceDots(const View& view, const Layer& layer,
                         const std::shared_ptr<const render::StippleSurface>& surface, bool onTheWay,
                         DotHistory::Layer& history) {
    const StippleStyle& style = *layer.stipple();
    if (history.surface.lock() != surface || !style.soft()) history = {surface, {}};
    const render::SurfaceDots dots(*surface, style, view, layer.transform, layer.clips());
    auto seen = dots.seen(dots.chosen());
    if (!style.soft()) return dots.onScreen(seen);
    return dots.onScreen(onTheWay ? history.points.step(*surface, dots, std::move(seen))
                                  : history.points.settle(std::move(seen)));
}

std::shared_ptr<const render::Dots> DrawnPhotographs::dots(const Tiles& tiles, const Image& image,
                                                           const View& view, const StippleStyle& style,
                                                           const render::PhotographEffort& effort) {
    const auto same = [&](const Drawn& drawn) {
        return drawn.tiles.lock() == tiles && drawn.image.lock() == image && drawn.width == view.width &&
               drawn.height == view.height && drawn.style == style && drawn.effort == effort;
    };
    const auto draw = [&] {
        auto dots = render::photographDots(*tiles, *image, view.width, view.height, style, effort);
        return Drawn{tiles,
                     image,
                     view.width,
                     view.height,
                     style,
                     effort,
                     std::make_shared<const render::Dots>(std::move(dots))};
    };
    return mostRecent(drawn_, mostDrawn, same, draw).dots;
}

Status checkDots(const View& view, const StippleStyle& style) {
    const double dots =
        render::densityOfSpacing(lengthOf(style, style.kSpacingPixelsFieldNumber)) * view.width * view.height;
    if (dots <= mostDots) return success();
    return Error{ErrorCode::resourceExhausted, "stipple.spacingPixels",
                 fmt::format("asks for up to {:.0f} dots; a picture may have {:.0f}", dots, mostDots)};
}

void addDots(render::Scene& scene, const render::Dots& dots, const Layer& layer) {
    auto all = scene.dots ? std::make_shared<render::Dots>(*scene.dots) : std::make_shared<render::Dots>();
    const auto clips = layer.onScreen() ? layer.clips() : HalfSpaces();
    for (auto dot : dots) {
        if (!inAll(clips, placeInPicture(dot.x, dot.y, scene.view.width, scene.view.height))) continue;
        dot.opacity *= static_cast<float>(layer.opacity);
        all->push_back(dot);
    }
    scene.dots = std::move(all);
}

}  // namespace mote::server
