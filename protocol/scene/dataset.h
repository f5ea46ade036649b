// SPDX-License-Identifier: GPL-3.0-or-later
//
// What every program may ask of a dataset by its manifest, whatever its kind: the layer that draws it, its
// steps, its box. One table of kinds stands behind it (dataset.cpp); what only storage must know of a kind
// stands in storage/dataset_kind.h. Pure functions; a manifest that nobody has checked does no harm.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"
#include "protocol/scene/camera.h"

namespace mote {

/// The kinds of layers that draw datasets of a kind ("particles", ...), the usual one first; none where none
/// does by itself.
std::span<const proto::Layer::KindCase> layersThatDraw(std::string_view datasetKind);

/// Steps of a series; none of a dataset without time.
int stepCount(const proto::Manifest& manifest);

/// A dataset as it is first seen: by the usual kind of layer, every field left to the server, in the middle
/// of its time; of so many pixels. Nothing where no layer draws it by itself.
std::optional<proto::View> firstView(const std::string& name, std::string_view datasetKind, int steps,
                                     std::uint32_t width, std::uint32_t height);

/// The box that it fills, in layer space: of a mesh or a volume its own units, of a plot [-1, 1].
Bounds datasetBounds(const proto::Manifest& manifest);
/// From where it is looked at, layer space: from the front as its file or who prepared it has it; none where
/// neither says.
std::optional<Outlook> datasetOutlook(const proto::Manifest& manifest);
/// Whether a volume says no space, but Hounsfield units, so that its slices are taken to lie as scanners
/// write them: from feet to head, the back last.
bool takenForPatient(const proto::Manifest& manifest);
/// A direction by its name: "x", "-x", ... ; none of any other.
std::optional<glm::dvec3> findDirection(std::string_view name);
/// The box of a hybrid volume.
Bounds volumeBounds(const proto::HybridManifest& hybrid);

}  // namespace mote
