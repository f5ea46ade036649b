// SPDX-License-Identifier: GPL-3.0-or-later
//
// Writes a whole step file, NAME.h5, and its digest, NAME.digest, from arrays in memory; who has them in
// pieces takes StepFile. The same content gives the same bytes. One call at a time in a process: HDF5 is not
// thread-safe.
#pragma once

#include <filesystem>
#include <string>

#include "protocol/scene/error.h"
#include "storage/particles/step_content.h"

namespace mote::storage {

/// `directory`/`name`.h5 and .digest, both new. Errors: resourceExhausted (disk full), permissionDenied,
/// alreadyExists, internal; the directory may then hold parts of them.
Status writeStep(const std::filesystem::path& directory, const std::string& name, const StepContent& content);

/// "step-000012"
std::string stepName(std::uint32_t step);

}  // namespace mote::storage
