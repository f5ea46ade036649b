// SPDX-License-Identifier: GPL-3.0-or-later
//
// StepTree: octree and leaves of a mapped step, in memory of our own. Their numbers index other things, so
// they are copied from the mapping once, the copies held to the digests and checked: whoever writes into the
// file afterwards changes nothing that a reader of the tree goes by. With a budget the tree counts as one
// block, which may go while it is not used; it is copied and checked anew when it comes back. Who still reads
// it then keeps it (OctreeNodes::keeper), and it counts as long. Owned by MappedStep; any thread.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "protocol/base/error.h"
#include "storage/blocks/block_budget.h"
#include "storage/blocks/counted_memory.h"
#include "storage/blocks/verified_array.h"
#include "storage/particles/particle_step.h"
#include "storage/particles/step_layout.h"

namespace mote::storage {

class StepTree final : public BudgetedBlocks {
  public:
    /// The arrays of a step file up to leafDensity are its.
    static constexpr std::size_t arrayCount = static_cast<std::size_t>(StepArray::leafDensity) + 1;

    /// What the numbers are held to.
    struct Bounds {
        std::uint64_t points = 0;
        std::uint32_t maxLevel = 0;
    };
    struct Tree {
        OctreeNodes nodes;
        Leaves leaves;
    };

    /// `arrays`: the step's, by StepArray; they outlive this. `budget` may be null. `file`: its path, for
    /// errors.
    StepTree(std::span<const VerifiedArray> arrays, std::shared_ptr<BlockBudget> budget, Bounds bounds,
             std::string file);
    ~StepTree();
    StepTree(const StepTree&) = delete;
    StepTree& operator=(const StepTree&) = delete;

    /// Waits for it if it is not in memory. Uses all threads of the calling arena. Throws StorageError
    /// (corrupt, with file and array; resourceExhausted).
    Tree get() const;
    /// Brings it in, or marks it used, in `generation`. False if the budget has no room but for what was
    /// used since. That it is wrong is left to those who ask for it. Throws StorageError (resourceExhausted).
    bool bring(Generation generation) const;
    /// Whether get() returns, or throws, at once.
    bool ready() const;
    std::uint64_t bytes() const { return bytes_; }

    std::size_t blockCount() const override { return 1; }
    std::uint64_t blockSize(std::size_t) const override { return 0; }
    Generation usedIn(std::size_t) const override { return used_.load(std::memory_order_relaxed); }
    std::uint64_t giveUp(std::size_t block, Generation used) const override;

  private:
    /// The copy's memory, which counts itself.
    struct Memory {
        CountedMemory counted;
        std::unique_ptr<std::byte[]> bytes;
    };
    struct Copy {
        std::shared_ptr<Memory> memory;
        Tree tree;
    };

    std::optional<Tree> held(Generation generation) const;
    Tree load(Generation generation, CountedMemory counted) const;
    Copy copy(CountedMemory counted) const;
    Tree over(const std::shared_ptr<const Memory>& memory) const;

    const std::span<const VerifiedArray> arrays_;
    const std::shared_ptr<BlockBudget> budget_;
    const Bounds bounds_;
    const std::string file_;
    std::array<std::uint64_t, arrayCount> begin_{};  ///< of each array in the copy
    std::uint64_t bytes_ = 0;                        ///< of the copy

    mutable std::mutex loading_;               ///< one thread at a time; the budget is asked beneath it
    mutable std::optional<Error> error_;       ///< under loading_
    mutable std::atomic<bool> wrong_{false};   ///< whether there is an error_
    mutable std::mutex holding_;               ///< innermost: nothing is asked beneath it
    mutable std::optional<Copy> copy_;         ///< under holding_
    mutable std::atomic<Generation> used_{0};  ///< written under holding_; 0: not in memory
};

}  // namespace mote::storage
