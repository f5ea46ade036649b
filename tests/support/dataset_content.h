// SPDX-License-Identifier: GPL-3.0-or-later
//
// All that a program of ours may read of any dataset. A plain function.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "storage/blocks/block_budget.h"

namespace mote::test {

/// Memory that a dataset may take in these tests, by what its manifest says.
inline constexpr std::uint64_t mostSampleBytes = std::uint64_t{64} << 20;

/// Loads all of a dataset as the server does, whatever its kind, and refuses what it would say takes more
/// than `mostSampleBytes`: its content as bytes, the same for datasets that give the same pictures and
/// numbers. Throws storage::StorageError, and nothing else. `budget`: of what stays in memory of particles;
/// null: all.
std::string contentOfDataset(const std::filesystem::path& dataset,
                             std::shared_ptr<storage::BlockBudget> budget = nullptr);

}  // namespace mote::test
