// SPDX-License-Identifier: GPL-3.0-or-later
//
// Writes the columns of a step beside its points, once its step file stands: each rank some of the columns.
// Values go from the order of the source's rows, in which they are read, to that of the points, as many
// columns at once as the memory holds; if it does not hold one, range of rows after range of rows. Called
// from one thread; uses all threads of its arena. The same bytes for any ranks, threads and memory.
//
// ColumnSample: rows of a step that its plot holds, evenly strided in the order of its points, with what the
// columns beside them are made from. How columns are coded is chosen by them, not by what the source holds
// besides: lost particles, and those beyond the bounds. Filled while all rows are read for something else.
// Owned by the job; take() may be called from any thread, all else from one.
//
// KeptColumns: which columns of a run a job keeps beside the points of its plot, what is read of the source
// for them, and what the manifest says of them. A value and pure functions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "preprocess/job.h"
#include "preprocess/parallel/communicator.h"
#include "preprocess/particles/column_coding.h"
#include "preprocess/particles/lost_filter.h"
#include "preprocess/particles/plot_axis.h"
#include "preprocess/particles/record_store.h"
#include "preprocess/readers/particle_source.h"
#include "protocol/base/error.h"
#include "storage/files/writeback.h"
#include "storage/hash.h"
#include "storage/particles/particle_columns.h"
#include "storage/particles/step_file.h"

namespace mote::prep {

struct KeptColumn {
    std::string name, unit;
    std::optional<PlotAxis> axis;  ///< whose values it holds; none: 1 where the particle is lost, else 0

    bool isWeight() const { return name == "weight"; }
    /// What it is made from.
    std::vector<Column> sources() const { return axis ? axis->columns() : std::vector<Column>(); }
};

struct KeptColumns {
    std::vector<KeptColumn> columns;
    bool ids = false;

    bool empty() const { return columns.empty() && !ids; }
    /// What the columns are made from.
    std::vector<Column> sources() const;
    /// What the manifest says before any step's columns are there.
    void describe(const ParticleSource& source, proto::ParticlesManifest& manifest) const;
};

/// The columns of names as in a request ("none": none; no name: all that the run has of x y z t px py pz,
/// weight and id, and records that are kept; of a record of vectors all components). If lost particles are
/// among others, `marked`, their marks are kept. Errors: invalidArgument (no such name, or twice), notFound
/// (the run does not have it).
Result<KeptColumns> keptColumns(const google::protobuf::RepeatedPtrField<std::string>& names,
                                const ParticleSource& source, bool marked = false);

/// A column's value of each particle of a chunk, which has what its sources() name. `out` has the chunk's
/// size.
void evaluateColumn(const KeptColumn& column, const ParticleChunk& chunk, const BeamContext& context,
                    std::span<double> out);

class ColumnSample {
  public:
    static constexpr std::uint64_t most = std::uint64_t{1} << 16;

    /// Rows of the step's points; `wanted` is what is kept of them, `lost` which particles take part. Errors:
    /// internal, cancelled.
    static Result<ColumnSample> make(const storage::StepFile& points, std::uint64_t pointCount,
                                     std::vector<Column> wanted, LostParticles lost,
                                     const Progress& progress);
    ColumnSample(ColumnSample&& other) noexcept;

    const std::vector<Column>& wanted() const { return wanted_; }
    /// A chunk of the step, with what is wanted; each chunk once.
    void take(const ParticleChunk& chunk);
    /// What the ranks took, each of rows of its own that ascend with its number, becomes everyone's.
    Status share(Communicator& ranks);

    /// The rows that were taken, ascending.
    const ParticleChunk& rows() const { return chunk_; }
    /// The weights of all particles that take part and were read; least above greatest: there was none.
    double leastWeight() const { return leastWeight_; }
    double greatestWeight() const { return greatestWeight_; }

  private:
    ColumnSample() = default;

    std::vector<Column> wanted_;
    LostParticles lost_ = LostParticles::without;
    std::vector<std::uint64_t> row_;  ///< ascending
    std::vector<std::uint8_t> taken_;
    ParticleChunk chunk_;
    std::mutex mutex_;  ///< of the two below
    double leastWeight_ = std::numeric_limits<double>::infinity();
    double greatestWeight_ = -std::numeric_limits<double>::infinity();
};

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
    /// Rows of `points` as they are held, or nothing; what stands there is nothing that counts afterwards.
    std::span<std::uint32_t> heldRows;
    std::uint64_t memory = 0;             ///< bytes that this rank may take
    std::shared_ptr<StoreMemory> stores;  ///< of which those of columns come
    Communicator* ranks = nullptr;
    storage::Writeback* writeback = nullptr;  ///< begun with what is written, while the rest is made
    const Progress* progress = nullptr;
    /// Called once all columns are written, while the disk is waited for; on all ranks.
    std::function<Status()> meanwhile = {};
};

struct WrittenColumns {
    std::vector<ColumnCoding> codings;  ///< by column
    std::vector<double> resolutions;    ///< by column
    std::vector<double> least,
        greatest;            ///< by column, of finite values; least above greatest: there is none
    storage::FileHash hash;  ///< of NAME.h5; on rank 0
};

/// Makes NAME.h5 and NAME.digest. Errors: the source's own, resourceExhausted (disk full), cancelled,
/// those of `meanwhile`; the same on all ranks. Parts of the files may be left.
Result<WrittenColumns> writeColumns(const ColumnsRequest& request);

}  // namespace mote::prep
