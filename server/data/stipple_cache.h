// SPDX-License-Identifier: GPL-3.0-or-later
//
// StippleCache: the stippled surfaces that were drawn last, read whole and kept. Owned by DatasetService; for
// the one thread that renders.
#pragma once

#include <list>
#include <memory>

#include "protocol/scene/error.h"
#include "server/render/layers/stipple/stipple_surface.h"
#include "storage/catalogue.h"

namespace mote::server {

class StippleCache {
  public:
    static constexpr std::size_t mostSurfaces = 8;  ///< as many as a view has layers

    using Surface = std::shared_ptr<const render::StippleSurface>;

    /// Reads it where it is not kept. Errors: as storage::readHierarchy and readMesh; unsupported where its
    /// points lie on the plane.
    Result<Surface> surface(const storage::Catalogue::Entry& entry);

  private:
    struct Kept {
        std::shared_ptr<const proto::Manifest> manifest;  ///< tells a dataset from a later one of its name
        Surface surface;
    };
    std::list<Kept> kept_;  // the latest first
};

}  // namespace mote::server
