// SPDX-License-Identifier: GPL-3.0-or-later
//
// The shrinker: makes a view that fails as small as it can while it still fails: fewer layers, knots and
// cuts, fields left out, a smaller picture, rounder numbers. Pure functions but for what they ask.
#pragma once

#include <functional>

#include "protocol/mote.pb.h"

namespace mote::test {

using Fails = std::function<bool(const proto::View&)>;

/// A valid view that fails and of which nothing more can be left out; `view` itself where nothing can.
/// `mostQuestions`: after so many it is taken as it is.
proto::View shrunk(const proto::View& view, const Fails& fails, int mostQuestions = 2000);

}  // namespace mote::test
