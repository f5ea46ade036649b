// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is loaded of datasets to stipple: surfaces, hierarchies of the plane, and images. Values; `entry` is
// one of the catalogue's.
#pragma once

#include "server/data/loadable.h"
#include "server/render/layers/stipple/pixel_map.h"
#include "server/render/layers/stipple/plane_tiles.h"
#include "server/render/layers/stipple/stipple_surface.h"

namespace mote::server {

/// Errors: invalidArgument (a dataset of another kind), unsupported (its points lie on the plane).
Result<Loadable<render::StippleSurface>> stippleSurface(const storage::Catalogue::Entry& entry);

/// Errors: invalidArgument (a dataset of another kind, points on a surface).
Result<Loadable<render::PlaneTiles>> stipplePlane(const storage::Catalogue::Entry& entry);

/// A picture's luminance; a large one is averaged down. Errors: invalidArgument (a dataset of another kind).
Result<Loadable<render::PixelMap>> imageLuminance(const storage::Catalogue::Entry& entry);

}  // namespace mote::server
