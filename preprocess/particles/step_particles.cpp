// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/step_particles.h"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace mote::prep {
namespace {

constexpr std::uint64_t chunkRows = std::uint64_t{1} << 20;

std::vector<Column> wantedColumns(const PlotAxes& axes) {
    std::set<Column> columns{Column::weight};
    for (const auto& axis : axes) columns.insert(axis.columns.begin(), axis.columns.end());
    return {columns.begin(), columns.end()};
}

bool isLost(const ParticleChunk& chunk, std::size_t i) {
    return i < chunk.lost.size() && chunk.lost[i] != 0;
}

bool isWeight(double weight) {
    return std::isfinite(weight) && weight >= 0.0;
}

/// Calls `use(chunk)` for all rows of a step, in order.
template <class Use>
Status forEachChunk(ParticleSource& source, std::size_t step, const std::vector<Column>& wanted,
                    const Progress& progress, Use use) {
    const std::uint64_t rows = source.steps()[step].particles;
    ParticleChunk chunk;
    for (std::uint64_t begin = 0; begin < rows; begin += chunkRows) {
        if (progress.cancelled()) return Error{ErrorCode::cancelled, "", "cancelled"};
        const auto count = static_cast<std::size_t>(std::min(chunkRows, rows - begin));
        MOTE_RETURN_IF_ERROR(source.read(step, begin, count, wanted, chunk));
        MOTE_CHECK(chunk.size == count);
        for (const auto column : wanted) MOTE_CHECK(chunk[column].size() >= count);
        use(chunk);
    }
    return success();
}

/// Weighted mean of |p| over the live particles, summed in the order of the rows; 0 without any.
Result<double> meanMomentum(ParticleSource& source, std::size_t step, const Progress& progress) {
    double sum = 0.0;
    double weights = 0.0;
    const std::vector<Column> wanted{Column::px, Column::py, Column::pz, Column::weight};
    const auto status = forEachChunk(source, step, wanted, progress, [&](const ParticleChunk& chunk) {
        double chunkSum = 0.0;
        double chunkWeights = 0.0;
        for (std::size_t i = 0; i < chunk.size; ++i) {
            const double p = momentum(chunk, i);
            const double weight = chunk[Column::weight][i];
            if (isLost(chunk, i) || !std::isfinite(p) || !isWeight(weight)) continue;
            chunkSum += weight * p;
            chunkWeights += weight;
        }
        sum += chunkSum;
        weights += chunkWeights;
    });
    if (!status.ok()) return status.error();
    return weights > 0.0 ? sum / weights : 0.0;
}

/// Takes chunks into StepParticles; keeps its buffers between them.
class Collector {
  public:
    Collector(const PlotAxes& axes, const AxisContext& context, StepParticles& particles)
        : axes_(axes), context_(context), particles_(particles) {}

    void add(const ParticleChunk& chunk) {
        for (std::size_t a = 0; a < 3; ++a) {
            values_[a].resize(chunk.size);
            evaluateAxis(axes_[a], chunk, context_, values_[a]);
        }
        const auto& weight = chunk[Column::weight];
        for (std::size_t i = 0; i < chunk.size; ++i) {
            if (isLost(chunk, i)) {
                ++particles_.lost;
                continue;
            }
            const bool valid = std::isfinite(values_[0][i]) && std::isfinite(values_[1][i]) &&
                               std::isfinite(values_[2][i]) && isWeight(weight[i]);
            if (!valid) {
                ++particles_.invalid;
                continue;
            }
            for (std::size_t a = 0; a < 3; ++a) particles_.coordinate[a].push_back(values_[a][i]);
            particles_.weight.push_back(weight[i]);
            particles_.row.push_back(static_cast<std::uint32_t>(chunk.begin + i));
        }
    }

  private:
    const PlotAxes& axes_;
    AxisContext context_;
    StepParticles& particles_;
    std::array<std::vector<double>, 3> values_;
};

void reserve(StepParticles& particles, std::size_t rows) {
    for (auto& values : particles.coordinate) values.reserve(rows);
    particles.weight.reserve(rows);
    particles.row.reserve(rows);
}

}  // namespace

Result<StepParticles> loadStep(ParticleSource& source, std::size_t step, const PlotAxes& axes,
                               Progress& progress) {
    const auto& info = source.steps()[step];
    if (info.particles > maxStepRows) {
        return Error{ErrorCode::resourceExhausted, info.file,
                     fmt::format("has {} particles in one step; at most {} are possible", info.particles,
                                 maxStepRows)};
    }
    AxisContext context{source.mass(), 0.0};
    if (std::any_of(axes.begin(), axes.end(),
                    [](const auto& axis) { return axis.kind == AxisKind::delta; })) {
        const auto mean = meanMomentum(source, step, progress);
        if (!mean.ok()) return mean.error();
        context.meanMomentum = *mean;
    }
    StepParticles particles;
    reserve(particles, info.particles);
    Collector collector(axes, context, particles);
    const auto status = forEachChunk(source, step, wantedColumns(axes), progress,
                                     [&](const ParticleChunk& chunk) { collector.add(chunk); });
    if (!status.ok()) return status.error();
    return particles;
}

}  // namespace mote::prep
