// SPDX-License-Identifier: GPL-3.0-or-later
//
// Format: which reader a file needs, by the name that the user gives or by what the file holds. Functions
// without state.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::prep {

enum class Format : std::uint8_t { openpmd, h5part, impactZ, impactT, csv, npy };

/// The format that the job names, or what the first file holds and the others begin like. Errors: notFound,
/// unsupported (with what may be done), invalidArgument (an unknown name, files of different formats).
Result<Format> formatOf(const proto::ParticlesJob& job, const std::vector<std::filesystem::path>& files);

}  // namespace mote::prep
