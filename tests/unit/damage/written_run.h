// SPDX-License-Identifier: GPL-3.0-or-later
//
// A run of the tests as a dataset on disk, made with the writers and nothing of the job; and runs that are
// small enough for every byte of theirs to be changed. Plain functions of one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "tests/support/memory_run.h"

namespace mote::test {

/// Points in a dense corner of a thin cloud, with columns x, y, z, px, weight and ids; the volume has
/// 2^volumeLevel cells a side.
std::shared_ptr<const MemoryRun> cloudRun(std::uint64_t seed, std::uint64_t points, std::uint32_t steps,
                                          std::uint8_t volumeLevel);

/// Publishes "NAME.mote". Throws StorageError.
void writeRun(const MemoryRun& run, const std::filesystem::path& output);

}  // namespace mote::test
