// SPDX-License-Identifier: GPL-3.0-or-later
//
// Writes the columns of a step beside its points, once its step file stands: each rank some of the columns.
// Values go from the order of the source's rows, in which they are read, to that of the points, as many
// columns at once as the memory holds; where it does not hold one, range of rows after range of rows. Called
// from one thread; uses all threads of its arena. The same bytes for any ranks, threads and memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/parallel/communicator.h"
#include "preprocess/particles/column_coding.h"
#include "preprocess/particles/column_sample.h"
#include "preprocess/particles/kept_columns.h"
#include "preprocess/readers/particle_source.h"
#include "storage/files/writeback.h"
#include "storage/particles/particle_columns.h"
#include "storage/particles/step_file.h"

namespace mote::prep {

struct ColumnsRequest {
    ParticleSource* source = nullptr;
    std::size_t step = 0;  ///< of the source
    const KeptColumns* kept = nullptr;
    const ColumnSample* sample = nullptr;  ///< of the step's points, with what `kept` is made from
    BeamContext context;
    std::filesystem::path directory;  ///< of the dataset while it is made
    std::string name;                 ///< "columns-000012"
    const storage::StepFile* points = nullptr;
    std::uint64_t pointCount = 0;
    std::uint64_t memory = 0;  ///< bytes that this rank may take
    Communicator* ranks = nullptr;
    storage::Writeback* writeback = nullptr;  ///< begun with what is written, while the rest is made
    const Progress* progress = nullptr;
};

struct WrittenColumns {
    std::vector<ColumnCoding> codings;  ///< by column
    std::vector<double> resolutions;    ///< by column
    std::vector<double> least,
        greatest;  ///< by column, of finite values; least above greatest: there is none
};

/// Makes NAME.h5 and NAME.digest. Errors: the source's own, resourceExhausted (disk full), cancelled; the
/// same on all ranks. Parts of the files may be left.
Result<WrittenColumns> writeColumns(const ColumnsRequest& request);

}  // namespace mote::prep
