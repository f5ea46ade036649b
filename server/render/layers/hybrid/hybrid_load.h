// SPDX-License-Identifier: GPL-3.0-or-later
//
// These functions load steps of hybrid datasets, as they are drawn, from their files. They are pure but for
// the files, which are not trusted: every byte is held to what the dataset says of it. Loading works in
// parallel.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/mat4x4.hpp>
#include <memory>
#include <string>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"
#include "server/render/plan/grid_field.h"
#include "storage/files/path_beneath.h"

namespace mote::render {

/// The map from the volume's box to layer space. `hybrid`: a checked manifest's.
glm::dmat4 hybridBox(const proto::HybridManifest& hybrid);
Bounds hybridBounds(const proto::HybridManifest& hybrid);

/// What the dataset has of what was asked for; never `best`. Errors: unsupported, if it has not.
Result<HybridRepresentation> hybridParts(const proto::HybridManifest& hybrid, HybridRepresentation asked);

/// An estimate from the manifest of what a step takes in memory, loaded for a representation.
std::uint64_t hybridBytes(const proto::HybridManifest& hybrid, std::uint32_t step,
                          HybridRepresentation representation);

/// The same for what loading takes besides: the step's file if it is packed, what is told of each brick,
/// the places of a residual's bricks.
std::uint64_t hybridLoadingBytes(const proto::HybridManifest& hybrid, std::uint32_t step,
                                 HybridRepresentation representation);

/// A digest of the manifest, and so of all of its files: the same for datasets that are drawn the same.
std::string hybridDigest(const proto::Manifest& manifest);

/// `representation`: as hybridParts gives it; only what it draws is loaded. Errors: notFound (there is no
/// such step), as storage::HybridStep::open and storage::readResidual, resourceExhausted (too many bricks).
Result<std::shared_ptr<const GridField>> loadHybrid(const storage::PathBeneath& directory,
                                                    const proto::Manifest& manifest, std::uint32_t step,
                                                    HybridRepresentation representation,
                                                    const std::function<bool()>& cancelled = {});

}  // namespace mote::render
