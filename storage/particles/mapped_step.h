// SPDX-License-Identifier: GPL-3.0-or-later
//
// MappedStep: the ParticleStep that lies in a mapped file. Made by ParticleStep::open; verify() also looks at
// what nobody has asked for yet, and StepLoader brings in what will be asked for.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

#include "storage/blocks/mapped_file.h"
#include "storage/blocks/verified_array.h"
#include "storage/particles/particle_step.h"
#include "storage/particles/step_layout.h"
#include "storage/particles/step_tree.h"
#include "storage/step_origin.h"

namespace mote::storage {

class MappedStep final : public ParticleStep {
  public:
    /// Something to do ahead of need: blocks [first, last) of an array to bring in, or, if there is no
    /// array, what follows from blocks that are there.
    struct Ahead {
        enum class Follows { previewScale, tree };

        const VerifiedArray* array = nullptr;
        std::size_t first = 0;
        std::size_t last = 0;
        Follows follows = Follows::tree;
    };

    /// As ParticleStep::open; `step` is one of the manifest's.
    static Result<std::shared_ptr<const MappedStep>> open(const PathBeneath& directory,
                                                          const proto::Manifest& manifest, std::uint32_t step,
                                                          std::shared_ptr<BlockBudget> budget = nullptr);
    ~MappedStep() override;

    const StepOrigin& origin() const { return origin_; }
    OctreeNodes nodes() const override { return tree_->get().nodes; }
    Leaves leaves() const override { return tree_->get().leaves; }
    std::uint64_t pointCount() const override { return array(StepArray::pointRow).size(); }
    std::span<const PackedPosition> positions(std::uint64_t begin, std::uint64_t count) const override;
    std::span<const std::uint64_t> rows(std::uint64_t begin, std::uint64_t count) const override;
    std::span<const float> volume() const override;
    std::uint32_t volumeSize() const override { return volumeSize_; }
    Preview preview(std::uint64_t most) const override;
    LogDensity logDensity() const override { return logDensity_; }
    bool octreeReady() const override;
    bool volumeReady() const override;
    std::uint64_t positionsReady(std::uint64_t begin, std::uint64_t count) const override;
    std::uint64_t previewReady(std::uint64_t most) const override;
    void check() const override;

    /// What to do for a need, in this order; ranges are cut to what there is.
    std::vector<Ahead> aheadOf(const StepNeed& need) const;
    /// False if the budget has no room for it but for what was used since `generation`. Throws
    /// StorageError; that the octree is wrong is left to those who ask for it.
    bool follow(Ahead::Follows follows, BlockBudget::Generation generation) const;
    /// check() throws this from now on.
    void fail(const Error& error) const;
    /// Bytes that must be in memory at once: octree, leaves and volume.
    std::uint64_t bytesAtOnce() const;

    /// Hashes every block and checks octree and leaves: what is wrong, nothing if all is well. Stops
    /// early, with a `cancelled` error, if `cancelled` says so.
    std::vector<Error> verify(const std::function<bool()>& cancelled) const;

  private:
    MappedStep(MappedFile file, std::string name, std::shared_ptr<BlockBudget> budget)
        : file_(std::move(file)), name_(std::move(name)), budget_(std::move(budget)) {}
    Status readArrays(const proto::Digest& digest);
    /// Errors: resourceExhausted.
    Status enterBudget() const;
    Status checkShapes(const proto::ParticleStepEntry& entry) const;
    const VerifiedArray& array(StepArray which) const { return arrays_[static_cast<std::size_t>(which)]; }
    LogDensity ownScale() const;
    LogDensity findScale() const;
    void requirePoints(std::uint64_t begin, std::uint64_t count) const;

    MappedFile file_;
    std::string name_;                           ///< the file's path
    const std::shared_ptr<BlockBudget> budget_;  ///< may be null
    std::vector<VerifiedArray> arrays_;          ///< by StepArray
    std::optional<StepTree> tree_;               ///< there from readArrays() on
    StepOrigin origin_;
    std::uint32_t volumeSize_ = 0;
    std::uint32_t maxLevel_ = 0;
    LogDensity logDensity_;
    mutable std::mutex scaleMutex_;
    mutable LogDensity scale_;  ///< under the mutex, until it is known
    mutable std::atomic<bool> scaleKnown_{false};
    mutable std::mutex failureMutex_;
    mutable std::optional<Error> failure_;  ///< under the mutex
};

}  // namespace mote::storage
