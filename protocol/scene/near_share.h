// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where a perspective camera begins to see. A constant.
#pragma once

namespace mote {

/// Nothing nearer to the eye than this share of the distance to the camera's target is seen, in every device,
/// in the reference and by a lasso.
inline constexpr double nearShare = 1e-3;

}  // namespace mote
