// SPDX-License-Identifier: GPL-3.0-or-later
//
// What layers of particles carry besides their style: a colour by a column, a selection, a highlight, paths.
// Each is read, written and shown to visitors here, so that view.cpp knows none of them. Pure functions.
#pragma once

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "protocol/scene/field_visitor.h"
#include "protocol/scene/view.h"

namespace mote {

/// Into a layer whose style is there. Errors: of each part; one of a layer that is not of particles.
Status parseLayerParts(const proto::Layer& message, const NamedSelectionMessages& named, Layer& layer);

void writeLayerParts(const Layer& layer, proto::Layer& message);

/// Shows all fields of style and parts of a layer beside those of another of the same kind.
void visitLayer(Layer& layer, const Layer& other, FieldVisitor& visitor);

/// How many ids and points the selections of the layer hold.
std::size_t valueCount(const Layer& layer);

}  // namespace mote
