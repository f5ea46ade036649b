// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/data/photograph_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "server/render/layers/stipple/tone.h"
#include "storage/image/image_file.h"
#include "storage/stipple/hierarchy_file.h"

namespace mote::server {
namespace {

constexpr std::size_t mostKept = 2;
constexpr double mostDots = 1 << 24;  ///< of one layer; half a GiB while they are made
/// Of an image in memory, 12 bytes each; larger ones are averaged down.
constexpr std::uint64_t mostPixels = std::uint64_t{1} << 23;

/// Moves what fits to the front; null where there is none.
template <class List, class Fits>
auto* find(List& list, const Fits& fits) {
    const auto found = std::find_if(list.begin(), list.end(), fits);
    if (found != list.end()) list.splice(list.begin(), list, found);
    return found != list.end() ? &list.front() : nullptr;
}

template <class List, class Value>
void keep(List& list, Value value) {
    list.push_front(std::move(value));
    if (list.size() > mostKept) list.pop_back();
}

}  // namespace

Result<std::shared_ptr<const render::PlaneTiles>> PhotographCache::tiles(const std::string& dataset) {
    const auto place = source_.place(dataset);
    if (!place.ok()) return place.error();
    const auto same = [&](const auto& kept) { return kept.manifest == place->manifest; };
    if (const auto* kept = find(tiles_, same)) return kept->value;
    auto hierarchy = storage::readHierarchy(place->directory, *place->manifest);
    if (!hierarchy.ok()) return hierarchy.error();
    if (place->manifest->stipple().domain() != proto::StippleManifest::PLANE) {
        return Error{ErrorCode::invalidArgument, "dataset",
                     "a picture is stippled with a hierarchy of the plane, not with one of a surface"};
    }
    auto made = std::make_shared<const render::PlaneTiles>(
        std::make_shared<const storage::StippleHierarchy>(*std::move(hierarchy)));
    keep(tiles_, Kept<render::PlaneTiles>{place->manifest, made});
    return made;
}

Status PhotographCache::checkDots(const View& view, const StippleStyle& style) {
    const double dots = render::densityOfSpacing(style.spacing) * view.width * view.height;
    if (dots <= mostDots) return success();
    return Error{ErrorCode::resourceExhausted, "stipple.spacingPixels",
                 fmt::format("asks for up to {:.0f} dots; a picture may have {:.0f}", dots, mostDots)};
}

Result<std::shared_ptr<const render::PixelMap>> PhotographCache::image(const std::string& dataset) {
    const auto place = source_.place(dataset);
    if (!place.ok()) return Error{place.error().code, "stipple.image", place.error().message};
    const auto same = [&](const auto& kept) { return kept.manifest == place->manifest; };
    if (const auto* kept = find(images_, same)) return kept->value;
    auto picture = storage::readImage(place->directory, *place->manifest, mostPixels);
    if (!picture.ok()) return picture.error();
    auto made =
        std::make_shared<const render::PixelMap>(picture->width, picture->height, std::move(picture->values));
    keep(images_, Kept<render::PixelMap>{place->manifest, made});
    return made;
}

Result<std::shared_ptr<const render::Dots>> PhotographCache::dots(const View& view, const Layer& layer,
                                                                  const render::PhotographEffort& effort) {
    const auto& style = *layer.stipple();
    MOTE_RETURN_IF_ERROR(checkDots(view, style));
    const auto plane = tiles(layer.dataset);
    if (!plane.ok()) return plane.error();
    const auto picture = image(style.image);
    if (!picture.ok()) return picture.error();
    const auto* known = find(drawn_, [&](const Drawn& drawn) {
        return drawn.tiles == *plane && drawn.image == *picture && drawn.width == view.width &&
               drawn.height == view.height && drawn.style == style && drawn.effort == effort;
    });
    if (known) return known->dots;
    auto dots = std::make_shared<const render::Dots>(
        render::photographDots(**plane, **picture, view.width, view.height, style, effort));
    keep(drawn_, Drawn{*plane, *picture, view.width, view.height, style, effort, dots});
    return dots;
}

}  // namespace mote::server
