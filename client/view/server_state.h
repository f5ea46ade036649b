// SPDX-License-Identifier: GPL-3.0-or-later
//
// ServerState: what the viewer knows of its server, for the panel to show. A value, filled by the viewer from
// the connection; main thread.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "protocol/mote.pb.h"

namespace mote::client {

struct ServerState {
    std::string connection;  ///< "connected to mote-server 0.1.0, egl (llvmpipe)"
    bool connected = false;
    double framesPerSecond = 0.0;
    double roundTripMs = 0.0;
    double bytesPerSecond = 0.0;
    bool savesData = false;  ///< fewer bytes are asked for
    proto::Catalogue catalogue;
    std::shared_ptr<const proto::Description> shown;  ///< of the dataset in the view
    std::shared_ptr<const proto::Frame> frame;        ///< header of the picture on the screen
    /// Particles seen in the region of the picture that is dragged, by density, in the bins of the plot.
    std::vector<std::uint64_t> litDensities;
    std::vector<proto::JobStatus> jobs;  ///< newest first
    std::uint64_t allJobs = 0;           ///< how many the server knows
};

}  // namespace mote::client
