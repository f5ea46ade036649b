// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/particles/step_tree.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <new>
#include <utility>
#include <vector>

#include "storage/hash.h"
#include "storage/particles/octree_check.h"
#include "storage/storage_error.h"

namespace mote::storage {
namespace {

constexpr std::uint64_t alignment = 16;  // of arrays in the copy, in bytes; elements have 8 at most

/// One block of an array, and where its copy lies.
struct BlockCopy {
    const VerifiedArray* array;
    std::size_t block;
    std::uint64_t begin;
};

}  // namespace

StepTree::StepTree(std::span<const VerifiedArray> arrays, std::shared_ptr<BlockBudget> budget, Bounds bounds,
                   std::string file)
    : arrays_(arrays.first(arrayCount)), budget_(std::move(budget)), bounds_(bounds), file_(std::move(file)) {
    for (std::size_t i = 0; i < arrayCount; ++i) {
        begin_[i] = bytes_;
        bytes_ += (arrays_[i].bytes() + alignment - 1) / alignment * alignment;
    }
}

StepTree::~StepTree() {
    if (copy_) copy_->memory->counted.giveUp();
}

std::optional<StepTree::Tree> StepTree::held(Generation generation) const {
    const std::lock_guard lock(holding_);
    if (!copy_) return std::nullopt;
    used_.store(std::max(used_.load(), generation));
    return copy_->tree;
}

StepTree::Tree StepTree::get() const {
    const auto generation = budget_ ? budget_->generation() : 1;
    if (auto tree = held(generation)) return *std::move(tree);
    const std::lock_guard lock(loading_);
    if (error_) throw StorageError(*error_);
    if (auto tree = held(generation)) return *std::move(tree);
    if (budget_ && !budget_->take(bytes_, generation) && !budget_->take(bytes_, generation + 1))
        budget_->takeAnyway(bytes_);
    return load(generation, {budget_, bytes_});
}

bool StepTree::bring(Generation generation) const {
    if (wrong_ || held(generation)) return true;
    const std::lock_guard lock(loading_);
    if (wrong_ || held(generation)) return true;
    if (budget_ && !budget_->take(bytes_, generation)) return false;
    try {
        load(generation, {budget_, bytes_});
    } catch (const StorageError&) {
        if (!wrong_) throw;
    }
    return true;
}

bool StepTree::ready() const {
    return wrong_ || used_.load(std::memory_order_relaxed) != 0;
}

std::uint64_t StepTree::giveUp(std::size_t, Generation used) const {
    std::optional<Copy> gone;  // freed when the mutex is
    const std::lock_guard lock(holding_);
    if (!copy_ || used_ != used) return 0;
    gone = std::exchange(copy_, std::nullopt);
    gone->memory->counted.giveUp();
    used_ = 0;
    return 0;
}

/// Under loading_. What is wrong with the file stays wrong; memory that is short may be there the next time.
StepTree::Tree StepTree::load(Generation generation, CountedMemory counted) const {
    try {
        auto copied = copy(std::move(counted));
        const std::lock_guard lock(holding_);
        copy_ = std::move(copied);
        used_ = generation;
        return copy_->tree;
    } catch (const std::bad_alloc&) {
        throw StorageError(Error{ErrorCode::resourceExhausted, file_, "there is no memory for its octree"});
    } catch (const StorageError& error) {
        error_ = error.error();
        wrong_ = true;
        throw;
    }
}

StepTree::Copy StepTree::copy(CountedMemory counted) const {
    const auto memory = std::make_shared<Memory>(
        Memory{std::move(counted), std::make_unique_for_overwrite<std::byte[]>(bytes_)});
    std::vector<BlockCopy> blocks;
    for (std::size_t i = 0; i < arrayCount; ++i) {
        for (std::size_t block = 0; block < arrays_[i].blockCount(); ++block) {
            arrays_[i].expect(block);
            blocks.push_back({&arrays_[i], block, begin_[i] + block * blockBytes});
        }
    }
    // In isolation: who waits here for others must not take up work that waits for loading_. In a context of
    // its own: what ends the work around it early must not leave parts out.
    tbb::task_group_context context(tbb::task_group_context::isolated);
    tbb::this_task_arena::isolate([&] {
        tbb::parallel_for(
            std::size_t{0}, blocks.size(),
            [&](std::size_t i) {
                const auto& [array, block, begin] = blocks[i];
                array->copyBlock(block, {memory->bytes.get() + begin, array->blockSize(block)});
            },
            context);
    });
    auto tree = over(memory);
    const auto checked = checkOctree(tree.nodes, tree.leaves, bounds_.points, bounds_.maxLevel);
    if (checked.ok()) return {memory, std::move(tree)};
    Error error = checked.error();
    error.where = file_ + ":" + error.where;
    throw StorageError(std::move(error));
}

StepTree::Tree StepTree::over(const std::shared_ptr<const Memory>& memory) const {
    const auto of = [&]<class T>(std::span<const T>& array, StepArray which) {
        const auto i = static_cast<std::size_t>(which);
        array = {reinterpret_cast<const T*>(memory->bytes.get() + begin_[i]), arrays_[i].size()};
    };
    Tree tree;
    of(tree.nodes.level, StepArray::octreeLevel);
    of(tree.nodes.morton, StepArray::octreeMorton);
    of(tree.nodes.firstChild, StepArray::octreeFirstChild);
    of(tree.nodes.childCount, StepArray::octreeChildCount);
    of(tree.nodes.count, StepArray::octreeCount);
    of(tree.nodes.density, StepArray::octreeDensity);
    of(tree.nodes.minDensity, StepArray::octreeMinDensity);
    of(tree.leaves.node, StepArray::leafNode);
    of(tree.leaves.pointBegin, StepArray::leafPointBegin);
    of(tree.leaves.pointCount, StepArray::leafPointCount);
    of(tree.leaves.density, StepArray::leafDensity);
    tree.nodes.keeper = tree.leaves.keeper = memory;
    return tree;
}

}  // namespace mote::storage
