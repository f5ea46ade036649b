// SPDX-License-Identifier: GPL-3.0-or-later
//
// What layers carry besides their style: of particles a colour by a column, a selection, a highlight, paths;
// of what has steps another step that they are on their way to. Each is read, written and shown to visitors
// here, so that view.cpp knows none of them. Pure functions.
#pragma once

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "protocol/scene/field_visitor.h"
#include "protocol/scene/view.h"

namespace mote {

/// Into a layer whose style is there. Errors: of each part; one of a layer of a kind that does not have it.
Status parseLayerParts(const proto::Layer& message, const NamedSelectionMessages& named, Layer& layer);

void writeLayerParts(const Layer& layer, proto::Layer& message);

/// Shows all fields of style and parts of a layer beside those of another of the same kind.
void visitLayer(Layer& layer, const Layer& other, FieldVisitor& visitor);

/// How many ids and points the selections of the layer hold.
std::size_t valueCount(const Layer& layer);

}  // namespace mote
