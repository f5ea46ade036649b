// SPDX-License-Identifier: GPL-3.0-or-later
//
// Another plot of the same run: the request that makes it and the name it goes by. Pure functions.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "protocol/mote.pb.h"

namespace mote::client {

using AxisNames = std::array<std::string, 3>;

/// The names of the axes that a particle job knows, in the order in which a list shows them.
std::span<const std::string_view> plotAxes();

/// The axes of a described plot; nothing if it is no particle plot.
std::optional<AxisNames> axesOf(const proto::Description& description);

/// The request for these axes of the shown plot's run: inputs and options as the first time, bounds by the
/// rule, of all steps or of each as the first time, its output beside the plot, named for the axes. Nothing
/// where the run is not within the server's reach.
std::optional<proto::JobRequest> replotRequest(const proto::Description& description, const AxisNames& axes);

}  // namespace mote::client
