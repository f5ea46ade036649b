// SPDX-License-Identifier: GPL-3.0-or-later
//
// All that a program of ours may read of any dataset. A function without state.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "storage/blocks/block_budget.h"

namespace mote::test {

/// Loads all of a dataset as the server does, whatever its kind, and refuses what it would say takes more
/// than 64 MiB: its content as bytes, the same for datasets that give the same pictures and numbers. Throws
/// storage::StorageError, and nothing else. `budget`: of what stays in memory of particles; null: all.
std::string contentOfDataset(const std::filesystem::path& dataset,
                             std::shared_ptr<storage::BlockBudget> budget = nullptr);

}  // namespace mote::test
