// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a job leaves beside its output when it is killed and cannot clean up itself. Pure, but for the files.
#pragma once

#include <cstddef>
#include <filesystem>

namespace mote::server {

/// Removes unpublished drafts of `output` from its folder; how many there were.
std::size_t removePartialOutput(const std::filesystem::path& output);

}  // namespace mote::server
