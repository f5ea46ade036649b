// SPDX-License-Identifier: GPL-3.0-or-later
//
// PhotographCache: plane hierarchies and images of datasets, ready to be drawn from, the latest few; and the
// dots of the latest photographs, so that a view in which they stay as they are does not make them again. Of
// the thread that renders.
#pragma once

#include <list>
#include <memory>

#include "protocol/scene/view.h"
#include "server/data/step_source.h"
#include "server/render/layers/stipple/photograph_dots.h"

namespace mote::server {

class PhotographCache {
  public:
    /// `source` must outlive it.
    explicit PhotographCache(StepSource& source) : source_(source) {}

    /// The dots of a layer with an image. Errors: notFound, corrupt, permissionDenied, invalidArgument (a
    /// dataset of another kind).
    Result<std::shared_ptr<const render::Dots>> dots(const View& view, const Layer& layer,
                                                     const render::PhotographEffort& effort);

    /// The plane hierarchy of a layer. Errors: as dots().
    Result<std::shared_ptr<const render::PlaneTiles>> tiles(const std::string& dataset);

    /// Whether a view may ask for so many dots. Errors: resourceExhausted.
    static Status checkDots(const View& view, const StippleStyle& style);

  private:
    using Manifest = std::shared_ptr<const proto::Manifest>;
    template <class T>
    struct Kept {
        Manifest manifest;  ///< tells a dataset from a later one of its name
        std::shared_ptr<const T> value;
    };
    struct Drawn {
        std::shared_ptr<const render::PlaneTiles> tiles;
        std::shared_ptr<const render::PixelMap> image;
        std::uint32_t width, height;
        StippleStyle style;
        render::PhotographEffort effort;
        std::shared_ptr<const render::Dots> dots;
    };

    Result<std::shared_ptr<const render::PixelMap>> image(const std::string& dataset);

    StepSource& source_;
    std::list<Kept<render::PlaneTiles>> tiles_;  // the latest first, here and below
    std::list<Kept<render::PixelMap>> images_;
    std::list<Drawn> drawn_;
};

}  // namespace mote::server
