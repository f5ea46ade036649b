// SPDX-License-Identifier: GPL-3.0-or-later
//
// ParticleFormat: which reader a file needs, by the name that the user gives or by what the file holds.
// Functions without state.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/readers/csv/csv_source.h"
#include "preprocess/readers/input_files.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/error.h"

namespace mote::prep {

enum class ParticleFormat : std::uint8_t {
    openpmd,
    h5part,
    impactZ,
    impactT,
    sdds,
    csv,
    npy,
    npz,
    tracewin,
    astra,
    genesis,
    elegant,
    tfs,
    json,
    gpt,
    ocelot,
    opal,
    pyorbit,
};

/// A run's files, all of one format.
struct ParticleFiles {
    ParticleFormat format = ParticleFormat::csv;
    std::vector<std::filesystem::path> paths;
};

/// What the job says of tables. Error: invalidArgument (a map that is none).
Result<CsvOptions> tableOptions(const proto::ParticlesJob& job);

/// The files of the format that the job names, else of that of the first file that is named and read. Of a
/// folder or a pattern it is that of most files; those of other formats are left out, with a note. Errors:
/// notFound, unsupported (with what may be done), invalidArgument (an unknown name, files of different
/// formats, in a folder as many of one as of another).
Result<ParticleFiles> detectFormat(const proto::ParticlesJob& job, const std::vector<InputFile>& files,
                                   Progress& progress);

}  // namespace mote::prep
