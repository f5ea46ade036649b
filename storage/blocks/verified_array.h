// SPDX-License-Identifier: GPL-3.0-or-later
//
// VerifiedArray: one array of a mapped file, in blocks of a MiB that are held to their digest when they are
// brought into memory, at their first use or ahead of it. With a budget, blocks may leave again and are
// verified anew when they come back. Safe to use from any number of threads; two that meet at a fresh block
// may both hash it, which does no harm.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "storage/blocks/block_budget.h"
#include "storage/blocks/mapped_file.h"

namespace mote::storage {

class VerifiedArray final : public BudgetedBlocks {
  public:
    /// `file` and `budget` must outlive this; no budget: what came in stays. Errors: corrupt, if the
    /// digest contradicts itself or the file's size.
    static Result<VerifiedArray> make(const MappedFile& file, const proto::DigestArray& digest,
                                      BlockBudget* budget);

    /// Slowest first.
    const std::vector<std::uint64_t>& shape() const { return shape_; }
    const std::string& type() const { return type_; }
    /// Elements.
    std::uint64_t size() const;
    std::uint64_t bytes() const { return bytes_.size(); }

    /// Elements [begin, begin + count), their blocks verified; T is what type() says. Throws StorageError
    /// (corrupt, with file, array and offset; resourceExhausted, if they are more than the budget).
    template <class T>
    std::span<const T> get(std::uint64_t begin, std::uint64_t count) const {
        use(begin * sizeof(T), count * sizeof(T));
        return {reinterpret_cast<const T*>(bytes_.data()) + begin, count};
    }
    template <class T>
    std::span<const T> all() const {
        return get<T>(0, bytes_.size() / sizeof(T));
    }
    /// How many of these bytes, from the first, are in memory.
    std::uint64_t ready(std::uint64_t offset, std::uint64_t length) const;

    std::size_t blockCount() const override { return blocks_.size(); }
    std::uint64_t blockSize(std::size_t block) const override;
    Generation usedIn(std::size_t block) const override {
        return used_[block].load(std::memory_order_relaxed);
    }
    std::uint64_t giveUp(std::size_t block, Generation used) const override;
    /// Brings a block in, or marks it used, in `generation`. False if the budget has no room but for what
    /// was used since. Throws StorageError (corrupt).
    bool bring(std::size_t block, BlockBudget::Generation generation) const;
    /// Tells the kernel that the block will be brought in soon.
    void expect(std::size_t block) const;
    /// Hashes one block, whether or not it was verified before; the Error names file, array and offset.
    std::optional<Error> checkBlock(std::size_t block) const;
    /// Copies a block into memory of the caller's, as large as the block, and holds the copy to the digest.
    /// The block counts as brought in no more than before. Throws StorageError (corrupt).
    void copyBlock(std::size_t block, std::span<std::byte> to) const;

  private:
    VerifiedArray() = default;
    void use(std::uint64_t offset, std::uint64_t length) const;
    void bringForUse(std::size_t block) const;
    std::optional<Error> holdToDigest(std::size_t block, std::span<const std::byte> bytes) const;
    bool touch(std::size_t block, BlockBudget::Generation generation) const;
    void load(std::size_t block, BlockBudget::Generation generation) const;

    const MappedFile* file_ = nullptr;
    BlockBudget* budget_ = nullptr;
    std::string where_;  ///< "DIR/step-000000.h5:/points/position"
    std::string type_;
    std::vector<std::uint64_t> shape_;
    std::uint64_t offset_ = 0;  ///< of bytes_ in the file
    std::span<const std::byte> bytes_;
    std::vector<std::uint64_t> blocks_;
    std::unique_ptr<std::atomic<BlockBudget::Generation>[]> used_;  ///< by block; 0: not in memory
};

}  // namespace mote::storage
