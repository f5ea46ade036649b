// SPDX-License-Identifier: GPL-3.0-or-later
//
// MemoryRun: a run without files, for tests of numbers: steps of points with columns beside them that a test
// chooses, or that nobody chose. Immutable once made; any number of threads.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "storage/numbers/run_steps.h"
#include "tests/support/memory_step.h"
#include "tests/support/random.h"

namespace mote::test {

class MemoryColumns final : public storage::ParticleColumns {
  public:
    struct Column {
        storage::ColumnInfo info;
        std::vector<float> values;
    };
    /// All of one length; in the order of the points.
    MemoryColumns(std::uint64_t points, std::vector<Column> columns,
                  std::optional<std::vector<std::uint64_t>> ids);

    std::uint64_t pointCount() const override { return points_; }
    const std::vector<storage::ColumnInfo>& columns() const override { return infos_; }
    std::span<const float> values(std::size_t column, std::uint64_t begin,
                                  std::uint64_t count) const override {
        return std::span(columns_[column].values).subspan(begin, count);
    }
    bool hasIds() const override { return ids_.has_value(); }
    std::span<const std::uint64_t> ids(std::uint64_t begin, std::uint64_t count) const override {
        return std::span(*ids_).subspan(begin, count);
    }
    std::span<const std::uint32_t> pointsById(std::uint64_t begin, std::uint64_t count) const override {
        return std::span(byId_).subspan(begin, count);
    }
    /// Of a point, as a number.
    double value(std::size_t column, std::uint64_t point) const {
        return infos_[column].offset + static_cast<double>(columns_[column].values[point]);
    }

  private:
    std::uint64_t points_;
    std::vector<Column> columns_;
    std::vector<storage::ColumnInfo> infos_;
    std::optional<std::vector<std::uint64_t>> ids_;
    std::vector<std::uint32_t> byId_;
};

class MemoryRun final : public storage::RunSteps {
  public:
    struct Step {
        std::shared_ptr<const MemoryStep> points;
        std::shared_ptr<const MemoryColumns> columns;  ///< may be null
    };
    /// `axes`: of its plot, where a test asks for them.
    MemoryRun(std::vector<Step> steps, BeamContext context, const std::vector<proto::Axis>& axes = {});

    const proto::ParticlesManifest& manifest() const override { return manifest_; }
    Result<storage::StepNumbers> step(std::uint32_t index) const override;
    const Step& at(std::uint32_t index) const { return steps_[index]; }
    const BeamContext& context() const { return context_; }

  private:
    std::vector<Step> steps_;
    BeamContext context_;
    proto::ParticlesManifest manifest_;
};

/// What a run that nobody chose is like.
struct AnyRun {
    std::uint64_t most = 3000;  ///< points of a step
    std::uint32_t steps = 3;
    bool ids = true;         ///< some repeat, some are not in all steps
    bool oddWeights = true;  ///< some are zero, some below
    bool odd = true;         ///< some values are NaN, some columns hold one value alone
};

/// With columns x, y, z, px, py, pz of a mismatched beam about an offset, and weight. Ids lie in
/// [0, AnyRun::most) or anywhere.
std::shared_ptr<const MemoryRun> anyRun(Random& random, const AnyRun& shape = {});

}  // namespace mote::test
