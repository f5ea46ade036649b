// SPDX-License-Identifier: GPL-3.0-or-later
//
// MeshRecord: a component of a mesh record of an openPMD file: its numbers and what its attributes say of the
// grid, checked. It keeps its file open; one thread at a time.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/readers/hdf5/h5_numbers.h"
#include "preprocess/volume/openpmd_mesh.h"
#include "protocol/scene/error.h"

namespace mote::prep {

struct MeshRecord {
    /// Of a grid, in the order of the file's dimensions; of thetaMode without that of the modes.
    struct Axis {
        std::string label;     ///< "x", "y", "z" or "r"
        double spacing = 1.0;  ///< m, over 0
        double first = 0.0;    ///< m, where the first value stands
    };

    H5Numbers numbers;
    std::vector<Axis> axes;
    bool thetaMode = false;
    double sineSign = 1.0;  ///< thetaMode: of the imaginary parts
    double unitSI = 1.0;
    std::string unit;            ///< "V/m"; "" where it is not known
    std::optional<double> time;  ///< s, of the iteration
    std::string where;
    std::vector<std::string> notes = {};  ///< what was assumed

    /// Errors: as openOpenpmdMesh.
    static Result<MeshRecord> open(const std::filesystem::path& path, const MeshField& field);
};

}  // namespace mote::prep
