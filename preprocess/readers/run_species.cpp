// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/readers/run_species.h"

#include <algorithm>

#include "preprocess/readers/format_detection.h"
#include "preprocess/readers/hdf5/h5_file.h"
#include "preprocess/readers/openpmd/layout.h"

namespace mote::prep {
namespace {

Status addSpecies(const std::filesystem::path& path, Progress& progress, std::vector<std::string>& names) {
    MOTE_ASSIGN_OR_RETURN(auto file, H5File::open(path));
    MOTE_ASSIGN_OR_RETURN(const auto root, findOpenpmdRoot(file));
    if (!root.empty()) MOTE_RETURN_IF_ERROR(file.enter(root));
    MOTE_ASSIGN_OR_RETURN(const auto layout, readOpenpmdLayout(file));
    for (const OpenpmdIteration& iteration : layout.iterations) {
        if (progress.cancelled()) return wasCancelled();
        const auto found = listSpecies(file, layout, iteration);
        if (!found.ok()) continue;  // who reads it says so
        for (const OpenpmdSpeciesPath& species : *found) {
            if (std::find(names.begin(), names.end(), species.name) == names.end())
                names.push_back(species.name);
        }
    }
    return success();
}

}  // namespace

Result<std::vector<std::string>> runSpecies(const proto::ParticlesJob& job,
                                            const std::vector<std::filesystem::path>& inputs,
                                            Progress& progress) {
    MOTE_ASSIGN_OR_RETURN(const auto files, inputFiles(inputs));
    MOTE_ASSIGN_OR_RETURN(const auto found, detectFormat(job, files, progress));
    std::vector<std::string> names;
    if (found.reader->name != "openpmd") return names;
    for (const std::filesystem::path& path : found.paths) {
        const Status added = addSpecies(path, progress, names);
        if (!added.ok() && added.error().code == ErrorCode::cancelled) return added.error();
    }
    return names;
}

}  // namespace mote::prep
