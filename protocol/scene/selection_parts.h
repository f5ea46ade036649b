// SPDX-License-Identifier: GPL-3.0-or-later
//
// The single conditions of a selection, parsed: what selection.h's parseSelection() is made of. Errors name
// the field within the condition. Pure functions.
#pragma once

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "protocol/scene/selection.h"

namespace mote {

Result<Selection::Range> parseRange(const proto::Selection::Range& message);
Result<Selection::Density> parseDensity(const proto::Selection::Density& message);
Result<Selection::Polygon> parsePolygon(const proto::Selection::Polygon& message);
Result<Selection::Lasso> parseLasso(const proto::Selection::Lasso& message);
Result<Selection::Outermost> parseOutermost(const proto::Selection::Outermost& message);

}  // namespace mote
