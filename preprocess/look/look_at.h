// SPDX-License-Identifier: GPL-3.0-or-later
//
// Looking at a foreign file: it is opened as a job would open it, and what it holds is told, with what would
// be assumed. Functions without state; they belong into a process of their own (confined_child.h).
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/look/found.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

struct LookOptions {
    proto::ParticlesJob particles;      ///< how a run would be read: format, species, map, masses
    proto::VolumeSourceOptions volume;  ///< the same of a volume
    bool all = false;                   ///< ranges of all steps, not of the first alone
    std::uint64_t memory = 0;           ///< bytes that meshes and pictures may take; 0: as memoryFor()
};

/// A file, a folder, or a name with %T: whatever it can be read as. Errors: notFound (there is no such file),
/// cancelled.
Result<Look> lookAt(const std::filesystem::path& input, const LookOptions& options, Progress& progress);

/// The same of one kind; what is not read is the error. Errors: as the kinds' readers.
Result<std::vector<Found>> lookAtParticles(const std::filesystem::path& input, const LookOptions& options,
                                           Progress& progress);
Result<std::vector<Found>> lookAtVolume(const std::filesystem::path& input, const LookOptions& options,
                                        Progress& progress);
Result<std::vector<Found>> lookAtMesh(const std::filesystem::path& input, const LookOptions& options,
                                      Progress& progress);
Result<std::vector<Found>> lookAtImage(const std::filesystem::path& input, const LookOptions& options,
                                       Progress& progress);

/// "--format" if the user named the format, else what its reader tells of its files.
std::string toldBy(const std::string& wantedFormat, std::string_view told);

/// Looks at each of several species or fields of a file. One that is not read is refused beside the others,
/// as part of what `whole` says of the file. Errors: those of `look`, of a single one, and cancelled.
Result<std::vector<Found>> lookAtEach(const std::vector<std::string>& names, const Found& whole,
                                      const std::function<Result<Found>(const std::string& name)>& look);

}  // namespace mote::prep
