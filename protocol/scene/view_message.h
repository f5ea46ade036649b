// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is made of views: their messages, views for pictures of more pixels, with all lengths in pixels, and
// with a camera that sees what their datasets hold. Pure functions.
#pragma once

#include <optional>
#include <span>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/bounds.h"
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

/// The same picture, with a scale of 1 and every length said: what devices are given, and what can be mixed
/// with another.
View lengthsInPixels(View view);

/// Errors: invalidArgument where a length that the view says is longer than it may be once it is scaled.
Status checkLengths(const View& view);

/// Whether a camera shows more or less of a layer: not of one that lies on the picture itself, or of which
/// there is nothing.
bool isFitted(const Layer& layer);

/// What of a fitted picture stays free on the left and right, and above and below, as shares of its width and
/// height: axes of plots get room for labels, bars of colours for themselves.
glm::dvec2 fitMargin(const View& view);
/// Of what is within: width over height.
double fittedAspect(const View& view);

/// How a view is looked at whose first fitted layer has an outlook of its own, in the layer's space; or none.
Outlook outlookOf(const std::optional<Outlook>& own, const glm::dmat4& transform);

/// What a dataset's manifest tells of where a layer lies, layer space.
struct LayerBox {
    Bounds box = plotBounds;
    std::optional<Outlook> outlook = {};
};

/// Fits the camera of a view that came without one to the boxes of its layers' datasets; another's stays as
/// it is. Nothing: there is none to be seen.
void fitLayers(View& view, std::span<const std::optional<LayerBox>> boxes);

}  // namespace mote
