// SPDX-License-Identifier: GPL-3.0-or-later
//
// What jobs read, read as jobs do. Each returns the error's sentence, "" where all was read, and aborts
// where a reader breaks its contract: columns are as long as they were asked for, weights not negative,
// shapes within bounds, and what is read again is the same. Functions without state.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "protocol/mote.pb.h"

namespace mote::test {

/// The first steps, with all columns that there are.
std::string readParticles(const proto::ParticlesJob& job, const std::vector<std::filesystem::path>& inputs);

/// The first, the last and again the first slice of each step.
std::string readVolume(const proto::VolumeSourceOptions& options, const std::filesystem::path& input);

}  // namespace mote::test
