// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/step_reader.h"

#include <fmt/format.h>
#include <oneapi/tbb/concurrent_queue.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace mote::prep {
namespace {

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

/// Weights times momenta of a block, and the weights.
struct MomentumSum {
    double product = 0.0;
    double weight = 0.0;
};

MomentumSum momentumSum(const ParticleChunk& chunk) {
    MomentumSum sum;
    for (std::size_t i = 0; i < chunk.size; ++i) {
        const double p = momentum(chunk, i);
        const double weight = chunk[Column::weight][i];
        if (isLost(chunk, i) || !std::isfinite(p) || !isWeight(weight)) continue;
        sum.product += weight * p;
        sum.weight += weight;
    }
    return sum;
}

}  // namespace

/// A block on its way; its memory serves block after block.
struct StepReader::Slot {
    std::size_t index = 0;
    bool isKept = false;
    ParticleChunk chunk;
    std::array<std::vector<double>, 3> values;
    ParticleBlock block;

    void collect(const PlotAxes& axes, const AxisContext& context) {
        for (std::size_t a = 0; a < 3; ++a) {
            values[a].resize(chunk.size);
            evaluateAxis(axes[a], chunk, context, values[a]);
            block.coordinate[a].resize(chunk.size);
        }
        block.weight.resize(chunk.size);
        block.row.resize(chunk.size);
        block.lost = 0;
        block.invalid = 0;
        const std::size_t size = fill();
        for (auto& coordinate : block.coordinate) coordinate.resize(size);
        block.weight.resize(size);
        block.row.resize(size);
    }

  private:
    std::size_t fill() {
        std::size_t size = 0;
        const auto& weight = chunk[Column::weight];
        for (std::size_t i = 0; i < chunk.size; ++i) {
            if (isLost(chunk, i)) {
                ++block.lost;
                continue;
            }
            if (!std::isfinite(values[0][i]) || !std::isfinite(values[1][i]) ||
                !std::isfinite(values[2][i]) || !isWeight(weight[i])) {
                ++block.invalid;
                continue;
            }
            for (std::size_t a = 0; a < 3; ++a) block.coordinate[a][size] = values[a][i];
            block.weight[size] = weight[i];
            block.row[size] = static_cast<std::uint32_t>(chunk.begin + i);
            ++size;
        }
        return size;
    }
};

Result<StepReader> StepReader::open(ParticleSource& source, std::size_t step, const PlotAxes& axes,
                                    Communicator& ranks, const Progress& progress, std::uint64_t mayKeep) {
    const auto& info = source.steps()[step];
    if (info.particles > maxStepRows) {
        return Error{ErrorCode::resourceExhausted, info.file,
                     fmt::format("has {} particles in one step; at most {} are possible", info.particles,
                                 maxStepRows)};
    }
    StepReader reader(source, step, axes, progress);
    reader.rows_ = info.particles;
    reader.mayKeep_ = mayKeep;
    const std::size_t blocks = (info.particles + blockRows - 1) / blockRows;
    const auto size = static_cast<std::size_t>(ranks.size());
    const auto rank = static_cast<std::size_t>(ranks.rank());
    reader.first_ = blocks * rank / size;
    reader.kept_.resize(blocks * (rank + 1) / size - reader.first_);
    reader.context_.mass = source.mass();
    if (std::any_of(axes.begin(), axes.end(),
                    [](const auto& axis) { return axis.kind == AxisKind::delta; })) {
        MOTE_RETURN_IF_ERROR(reader.findMeanMomentum(ranks));
    }
    return reader;
}

Status StepReader::readBlock(std::size_t index, const std::vector<Column>& wanted, ParticleChunk& chunk) {
    if (progress_->cancelled()) return Error{ErrorCode::cancelled, "", "cancelled"};
    const std::uint64_t begin = (first_ + index) * blockRows;
    const auto count = static_cast<std::size_t>(std::min(blockRows, rows_ - begin));
    MOTE_RETURN_IF_ERROR(source_->read(step_, begin, count, wanted, chunk));
    MOTE_CHECK(chunk.size == count);
    for (const auto column : wanted) MOTE_CHECK(chunk[column].size() >= count);
    return success();
}

/// Weighted mean of |p| over the live particles of all ranks, block by block in their order; 0 without any.
Status StepReader::findMeanMomentum(Communicator& ranks) {
    const std::vector<Column> wanted{Column::px, Column::py, Column::pz, Column::weight};
    std::vector<MomentumSum> sums;
    ParticleChunk chunk;
    Status status = success();
    for (std::size_t index = 0; index < blockCount() && status.ok(); ++index) {
        status = readBlock(index, wanted, chunk);
        if (status.ok()) sums.push_back(momentumSum(chunk));
    }
    MOTE_RETURN_IF_ERROR(agree(ranks, status));
    const auto all = shareValues<MomentumSum>(ranks, sums);
    if (!all.ok()) return all.error();
    MomentumSum total;
    for (const auto& ofRank : *all) {
        for (const auto& sum : ofRank) {
            total.product += sum.product;
            total.weight += sum.weight;
        }
    }
    context_.meanMomentum = total.weight > 0.0 ? total.product / total.weight : 0.0;
    return success();
}

void StepReader::keep(std::size_t index, Slot& slot) {
    ParticleBlock block = std::move(slot.block);
    keptBytes_ += block.bytes();
    slot.block = {};
    kept_[index] = std::move(block);
}

Status StepReader::forEach(std::size_t begin, std::size_t end,
                           const std::function<void(const ParticleBlock&, std::size_t)>& use) {
    if (begin == end) return success();
    const auto wanted = wantedColumns(*axes_);
    const auto tokens = 2 * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    std::vector<Slot> slots(std::min(tokens, end - begin));
    tbb::concurrent_bounded_queue<Slot*> free;
    for (auto& slot : slots) free.push(&slot);
    Status status = success();
    std::size_t next = begin;
    const auto read = [&](tbb::flow_control& control) -> Slot* {
        if (next == end || !status.ok()) {
            control.stop();
            return nullptr;
        }
        Slot* slot = nullptr;
        free.pop(slot);
        slot->index = next++;
        slot->isKept = kept_[slot->index].has_value();
        if (!slot->isKept) status = readBlock(slot->index, wanted, slot->chunk);
        if (status.ok()) return slot;
        control.stop();
        return nullptr;
    };
    const auto work = [&](Slot* slot) {
        if (slot->isKept) {
            use(*kept_[slot->index], slot->index);
        } else {
            slot->collect(*axes_, context_);
            use(slot->block, slot->index);
        }
        return slot;
    };
    const auto giveBack = [&](Slot* slot) {
        if (!slot->isKept && keptBytes_ + slot->block.bytes() <= mayKeep_) keep(slot->index, *slot);
        free.push(slot);
    };
    tbb::parallel_pipeline(
        slots.size(), tbb::make_filter<void, Slot*>(tbb::filter_mode::serial_in_order, read) &
                          tbb::make_filter<Slot*, Slot*>(tbb::filter_mode::parallel, work) &
                          tbb::make_filter<Slot*, void>(tbb::filter_mode::serial_out_of_order, giveBack));
    return status;
}

}  // namespace mote::prep
