// SPDX-License-Identifier: GPL-3.0-or-later
//
// Views as messages again, and views for pictures of more pixels. Pure functions.
#pragma once

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"
#include "protocol/scene/view.h"

namespace mote {

/// The message of a valid view, complete: parseView() gives the view again, colours and unit vectors to
/// rounding. What the view leaves to its datasets or to its layers (a curve, the opacity of points, the
/// camera) stays absent.
proto::View toProto(const View& view);

/// The same picture with `times` as many pixels on each side: so is its scale, and every length on the screen
/// is longer as many times. Errors: invalidArgument where a size, the scale or a length becomes larger than
/// it may be, or `times` is 0.
Result<View> magnified(const View& view, unsigned times);

}  // namespace mote
