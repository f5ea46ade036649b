// SPDX-License-Identifier: GPL-3.0-or-later
//
// Datasets of each kind, and what they are drawn as. Plain functions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/memory_run.h"

namespace mote::test {

// A run of the tests as a dataset on disk, made with the writers and nothing of the job; and runs that are
// small enough for every byte of theirs to be changed. Plain functions of one thread.

/// Points in a dense corner of a thin cloud, with columns x, y, z, px, weight and ids; the volume has
/// 2^volumeLevel cells a side.
std::shared_ptr<const MemoryRun> cloudRun(std::uint64_t seed, std::uint64_t points, std::uint32_t steps,
                                          std::uint8_t volumeLevel);

/// Publishes "NAME.mote". Throws StorageError.
void writeRun(const MemoryRun& run, const std::filesystem::path& output);

struct SampleDataset {
    std::string name;
    void (*write)(const std::filesystem::path& output);  ///< publishes "NAME.mote"
    /// Layers that it is drawn as, each alone, as a user writes them (tests/support/view_text.h). They call
    /// it "sample"; a photograph is stippled with "picture" or "plane" (writeCompanions()).
    std::vector<std::string> layers;
    bool large = false;    ///< so that not every byte of it can be changed
    bool counted = false;  ///< numbers are asked of it, too
};

/// One of each kind, some KiB each.
const std::vector<SampleDataset>& sampleDatasets();
/// Up to some MiB; one array spans blocks of its digest.
const std::vector<SampleDataset>& largeDatasets();

/// Publishes "picture.mote" and "plane.mote" in the folder.
void writeCompanions(const std::filesystem::path& folder);

}  // namespace mote::test
