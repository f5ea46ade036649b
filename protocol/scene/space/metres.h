// SPDX-License-Identifier: GPL-3.0-or-later
//
// "space": "metres" of a view: all layers lie where they are, in metres (docs/PICTURE.md, "Layers in
// metres"). A plot along x, y and z, in any order, lies along these axes of the world, by the bounds of its
// step; a volume, a mesh and a stippled surface by the unit of their world. What such a place takes to metres
// comes first, then the layer's own transform, in metres, then the view's stretch. Pure functions; a manifest
// that nobody has checked does no harm.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/mat4x4.hpp>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/view.h"

namespace mote {

/// From layer space to metres, of a step where steps differ in it. What lies in no space, as a picture or a
/// stipple hierarchy of the plane, stays as it is. Errors, at no place: invalidArgument, which name the
/// dataset as `name`: a plot with an axis that is no place, a world without a known unit.
Result<glm::dmat4> placeInMetres(const proto::Manifest& manifest, std::uint32_t step,
                                 const std::string& name);
/// The same of a plot.
Result<glm::dmat4> plotInMetres(const proto::ParticlesManifest& plot, std::uint32_t step,
                                const std::string& name);

/// placeInMetres() of a dataset's steps, for who does not keep the manifest.
struct DatasetPlace {
    std::vector<glm::dmat4> steps = {glm::dmat4(1.0)};  ///< one: of all
    std::string lacks = {};                             ///< the error's sentence without the name; "": none

    Result<glm::dmat4> of(std::uint32_t step, const std::string& name) const;
};
DatasetPlace datasetPlace(const proto::Manifest& manifest);

/// Tells the place of a dataset's step, as placeInMetres().
using PlaceOf = std::function<Result<glm::dmat4>(const std::string& dataset, std::uint32_t step)>;

/// From layer space to the world of a view in metres, of a layer between two steps in between. Errors: those
/// of `placeOf`.
Result<glm::dmat4> layerToWorld(const Layer& layer, const Metres& metres, const PlaceOf& placeOf);

/// Puts into the layers' transforms where they lie, and Metres::placed; a view of another space and one whose
/// layers are placed stay as they are. Errors: those of `placeOf`, at "layers[0].dataset".
Status placeLayers(View& view, const PlaceOf& placeOf);

}  // namespace mote
