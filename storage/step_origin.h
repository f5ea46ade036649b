// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepOrigin: where a step that is in memory came from, so that another process can open the same one. A
// value.
#pragma once

#include <filesystem>
#include <string>

namespace mote::storage {

struct StepOrigin {
    std::filesystem::path file;
    std::string digest;  ///< tells its content from another's: of particles FileEntry.xxh3_128 of the
                         ///< manifest, of hybrid volumes hash128 of the manifest
};

}  // namespace mote::storage
