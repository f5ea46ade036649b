// SPDX-License-Identifier: GPL-3.0-or-later
//
// Views whose lengths on the screen (length_scale.h) are told in pixels of their own picture. Pure functions.
#pragma once

#include "protocol/scene/error.h"
#include "protocol/scene/view.h"

namespace mote {

/// The same picture, with a scale of 1 and every length said: what devices are given, and what can be mixed
/// with another.
View lengthsInPixels(View view);

/// Errors: invalidArgument where a length that the view says is longer than it may be once it is scaled.
Status checkLengths(const View& view);

}  // namespace mote
