// SPDX-License-Identifier: GPL-3.0-or-later
//
// Scripts whose views are drawn at another size, or say what they show. Pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote {

/// A checked script, every view of which has that size and the same look: its scale goes with its height.
/// Errors: of checkScript(), where the size or a length that is scaled is larger than it may be.
Result<proto::Script> sizedScript(proto::Script script, std::uint32_t width, std::uint32_t height);

/// What a first picture says beside what it shows, in the viewer and in the page of browsers, whose build
/// reads it here: fields of Annotations.
inline constexpr std::array<std::string_view, 2> usualAnnotations{"axes", "color_bar"};
proto::Annotations annotatedAsUsual(proto::Annotations annotations);

/// The script, every view of which that says nothing of annotations has axes, labels and bars.
proto::Script annotatedScript(proto::Script script);

/// The script; if it is a film that goes through steps of a dataset, its axes stand around whole plots, where
/// views do not say around what: a box that followed each step would jump.
proto::Script withStillAxes(proto::Script script);

}  // namespace mote
