// SPDX-License-Identifier: GPL-3.0-or-later
//
// A view between steps is the mean of several pictures, in each of which every layer shows one step
// (docs/PICTURE.md, "Between steps"): which pictures these are. Pure functions.
#pragma once

#include <vector>

#include "protocol/scene/view.h"

namespace mote {

/// One of these pictures: that of each place of a part of [0, 1].
struct ViewPart {
    double place = 0.5;   ///< one of its places
    double weight = 1.0;  ///< how long the part is

    bool operator==(const ViewPart&) const = default;
};

/// Where the nearer step of each layer is shown.
inline constexpr double nearestPlace = 0.5;

/// At least one, ascending; their weights add up to 1. Only one where every layer shows one step alone.
std::vector<ViewPart> viewParts(const View& view);

/// What is shown at a place: a layer whose share is greater shows the step that it goes to, others their own.
/// What is on its way keeps the step that it does not show, as `towards`, for labels; nothing else has it.
View viewAt(View view, double place);

}  // namespace mote
