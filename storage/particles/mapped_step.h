// SPDX-License-Identifier: GPL-3.0-or-later
//
// MappedStep: the ParticleStep that lies in a mapped file. Made by ParticleStep::open; verify() also looks at
// what nobody has asked for yet.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <vector>

#include "storage/mapped_file.h"
#include "storage/particles/particle_step.h"
#include "storage/particles/step_layout.h"
#include "storage/particles/verified_array.h"

namespace mote::storage {

class MappedStep final : public ParticleStep {
  public:
    /// As ParticleStep::open; `step` is one of the manifest's.
    static Result<std::shared_ptr<const MappedStep>> open(const std::filesystem::path& directory,
                                                          const proto::Manifest& manifest,
                                                          std::uint32_t step);

    OctreeNodes nodes() const override;
    Leaves leaves() const override;
    std::uint64_t pointCount() const override { return array(StepArray::pointRow).size(); }
    std::span<const PackedPosition> positions(std::uint64_t begin, std::uint64_t count) const override;
    std::span<const std::uint64_t> rows(std::uint64_t begin, std::uint64_t count) const override;
    std::span<const float> volume() const override;
    std::uint32_t volumeSize() const override { return volumeSize_; }
    Preview preview(std::uint64_t most) const override;
    LogDensity logDensity() const override { return logDensity_; }

    /// Hashes every block and checks octree and leaves: what is wrong, nothing where all is well. Stops
    /// early, with a `cancelled` error, where `cancelled` says so.
    std::vector<Error> verify(const std::function<bool()>& cancelled) const;

  private:
    MappedStep(MappedFile file, std::string name) : file_(std::move(file)), name_(std::move(name)) {}
    Status readArrays(const proto::Digest& digest);
    Status checkShapes(const proto::ParticleStepEntry& entry) const;
    const VerifiedArray& array(StepArray which) const { return arrays_[static_cast<std::size_t>(which)]; }
    OctreeNodes rawNodes() const;
    Leaves rawLeaves() const;
    Status checkTree() const;
    LogDensity ownScale() const;
    /// Once, at the first use of the octree; throws StorageError.
    void requireTree() const;

    MappedFile file_;
    std::string name_;                   ///< the file's path
    std::vector<VerifiedArray> arrays_;  ///< by StepArray
    std::uint32_t volumeSize_ = 0;
    std::uint32_t maxLevel_ = 0;
    LogDensity logDensity_;
    mutable std::once_flag treeChecked_;
    mutable std::optional<Error> treeError_;  ///< written once, behind treeChecked_
};

}  // namespace mote::storage
