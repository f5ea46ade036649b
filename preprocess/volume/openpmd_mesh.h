// SPDX-License-Identifier: GPL-3.0-or-later
//
// Fields on meshes of openPMD files (HDF5) as volumes: cartesian ones of two or three dimensions as they lie
// in the file, whatever the order of their axes, and those of thetaMode geometry as their sum over all modes,
// on a cartesian grid or in the plane of an angle. Values in SI, lengths in m or a decimal part of it.
// Called from one thread.
//
// A field is named "[ITERATION:]RECORD[/COMPONENT][@DEGREES]": "rho", "E/x", "500:B/z", "E/r@90".
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/volume/volume_source.h"
#include "protocol/base/error.h"

namespace mote::prep {

struct MeshField {
    std::optional<std::int64_t> iteration;  ///< nothing: the only one
    std::string record;                     ///< "": the only one
    std::string component;                  ///< "": the record is a scalar
    std::optional<double> degrees;          ///< thetaMode: the plane of this angle
};
/// Errors: invalidArgument, at "field".
Result<MeshField> parseMeshField(const std::string& text);

bool beginsAsHdf5(std::string_view bytes);

/// Whether the file has openPMD's mark. Errors: as H5File::open.
Result<bool> holdsOpenpmd(const std::filesystem::path& path);

/// The field's names of all iterations of a file, each a step, in order; its own if it names one or there
/// is only one. Errors: as openOpenpmdMesh.
Result<std::vector<std::string>> meshSteps(const std::filesystem::path& path, const std::string& field);

/// The names of the fields of a file's first iteration, without it; none if it has not openPMD's mark.
/// Errors: notFound (it holds no meshes), corrupt, those of H5File.
Result<std::vector<std::string>> meshFields(const std::filesystem::path& path);

/// Errors: notFound (no such iteration, record or component: says which there are), unsupported (another
/// geometry, more than three dimensions, a constant), corrupt, invalidArgument (the field's name),
/// resourceExhausted (modes of more than 1 GiB), those of H5File.
Result<std::unique_ptr<VolumeSource>> openOpenpmdMesh(const std::filesystem::path& path,
                                                      const std::string& field);

}  // namespace mote::prep
