// SPDX-License-Identifier: GPL-3.0-or-later
//
// These functions turn a hybrid layer into a field: what its style leaves open is taken from its dataset.
// They are part of the picture's definition (docs/PICTURE.md), and pure.
#pragma once

#include <memory>

#include "protocol/scene/view.h"
#include "server/render/layers/lowering.h"

namespace mote::render {

/// The opacity if a style has none: the first preset that suits the values
/// (protocol/scene/curve_presets.h), which is what a viewer begins with.
Curve defaultOpacity(const GridField& field);

/// The transfer function of values in the source's unit.
TransferFunction transferOf(const HybridStyle& style, const GridField& field);

/// What the field has, if the style leaves it open.
HybridRepresentation resolved(HybridRepresentation asked, const GridField& field);

/// Tells a camera all of a field that is seen: samples, corrected or not, of a fiftieth of the greatest
/// opacity at least, that it takes.
void addShown(const GridField& field, const TransferFunction& transfer, HybridRepresentation drawn,
              CameraFit& fit);

/// Adds the layer's field to `out`. `index`: the layer's place in its view.
void lowerHybrid(const Layer& layer, std::size_t index, const HybridStyle& style,
                 const std::shared_ptr<const GridField>& field, Lowering& out);

}  // namespace mote::render
