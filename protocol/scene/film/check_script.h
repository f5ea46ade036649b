// SPDX-License-Identifier: GPL-3.0-or-later
//
// What can be wrong with a script by itself, before anybody asks for its datasets. Pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote {

/// A script of more frames than this is taken for a mistake; pictures are numbered with six digits.
inline constexpr std::uint64_t maxFrames = 1000000;
inline constexpr int maxKeyframes = 10000;  ///< and moves
inline constexpr double defaultFps = 30.0;
inline constexpr double leastFps = 1e-3, mostFps = 1e3;  ///< frames a second

/// Everything that is wrong with a script by itself: what it is made of (exactly one of views, keyframes, a
/// view with moves), every view, times and their number. Errors: invalidArgument and resourceExhausted, which
/// name the field: "keyframes[1].view.layers[0].step", "moves[2].turn.axis", "fps".
Status checkScript(const proto::Script& script);

/// Frames of a checked script. Of keyframes both ends are shown; moves end where the next frame would begin
/// again.
std::uint64_t frameCountOf(const proto::Script& script);

/// All datasets that a script shows, each once, in order of their names; images of stipples too.
std::vector<std::string> datasetsOf(const proto::Script& script);

}  // namespace mote
