// SPDX-License-Identifier: GPL-3.0-or-later
//
// NumPy arrays as volumes: .npy, or an array of a .npz archive. Called from one thread.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/volume/volume_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

bool beginsAsNpy(std::string_view bytes);

/// An array of three dimensions, which are z, y and x, or of four, the first of which counts volumes; in C
/// order, or in Fortran's, which is then held whole, at most 1 GiB. `field`: the number of a volume; of an
/// archive, NAME or NAME:NUMBER, where it holds more than one array of so many dimensions. Errors:
/// unsupported (other dimensions, complex numbers, fields, several arrays: a sentence that lists them),
/// notFound, resourceExhausted, those of openNpyArrays and chooseParts.
Result<std::unique_ptr<VolumeSource>> openNpy(const std::filesystem::path& path, const std::string& field);

/// The arrays of an archive that are volumes or series of them. Errors: those of openNpyArrays.
Result<std::vector<VolumeField>> npyFields(const std::filesystem::path& path);

/// The fields of all volumes of the array, where `field` leaves open which. Errors: as openNpy.
Result<std::vector<std::string>> npySteps(const std::filesystem::path& path, const std::string& field);

}  // namespace mote::prep
