// SPDX-License-Identifier: GPL-3.0-or-later
//
// A step's octree, points and volume from its particles, on all ranks together: particles are counted in the
// cells of a grid, sent to the ranks that own their ranges of cells, sorted there range by range, and the
// octree is put together from the ranges' parts. Called from one thread; uses all threads of its arena.
//
// Writes a built step to its file, all ranks together: each collects the points of parts of the file from
// those that have them, and writes those parts. Called from one thread; uses all threads of its arena.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "preprocess/particles/bounds_rule.h"
#include "preprocess/particles/octree.h"
#include "preprocess/particles/record_store.h"
#include "preprocess/particles/step_reader.h"
#include "storage/hash.h"
#include "storage/particles/step_file.h"

namespace mote::prep {

struct StepOptions {
    OctreeOptions octree;
    std::uint32_t volumeLevel = 0;  ///< 1 to 8
};

/// What a step needs while it is built, besides its particles.
struct StepResources {
    Communicator* ranks = nullptr;
    std::function<bool()> cancelled;
    std::uint64_t memory = 0;             ///< bytes for particles; beyond them they lie in a temporary file
    std::shared_ptr<StoreMemory> stores;  ///< that memory
    std::filesystem::path temporary;      ///< the folder of that file
};

struct StepCounts {
    std::uint64_t particles = 0, lost = 0, invalid = 0, outside = 0;
};

struct BuiltStep {
    StepCounts counts;
    Octree octree;
    std::vector<float> volume;  ///< the same on all ranks; volumeSize^3, x fastest
    std::uint32_t volumeSize = 0;
    RecordStore points;  ///< LeafPoints of this rank's ranges, in Morton order of their leaves
    /// The first of each rank's points among all in Morton order, and one more.
    std::vector<std::uint64_t> firstPoint;
};

/// The same for any number of threads and ranks and any memory. Errors: the source's own, as assembleOctree,
/// resourceExhausted (memory, disk), cancelled; the same on all ranks.
Result<BuiltStep> buildStep(StepReader& reader, const std::array<Range, 3>& bounds,
                            const StepOptions& options, const StepResources& resources);

struct StepOutput {
    std::filesystem::path directory;  ///< of the dataset while it is made
    std::string name;                 ///< "step-000012"
    storage::StepAttributes attributes;
    Communicator* ranks = nullptr;
    std::function<bool()> cancelled;
    std::shared_ptr<StoreMemory> stores;  ///< that of the step's points, which the preview takes over
    /// One for each point, which becomes its row; empty: none are held. One rank alone may hold them.
    std::span<std::uint32_t> rows = {};
    bool rowsAreRead = true;  ///< soon, by which columns are put in order
    /// Called by rank 0 when all is written; then the file's hash is found, which is handed to `complete`.
    std::function<void()> written;
    std::function<void(storage::FileHash)> complete;  ///< called by rank 0
};

/// Makes NAME.h5 and NAME.digest; returns where the arrays lie in it. `step` is left without its points.
/// Errors: resourceExhausted (disk full, memory), permissionDenied, cancelled, internal; the same on all
/// ranks. Parts of the files may be left.
Result<storage::StepFile::Places> writeBuiltStep(BuiltStep& step, const StepOutput& output);

}  // namespace mote::prep
