// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/step_reader.h"

#include <fmt/format.h>
#include <oneapi/tbb/concurrent_queue.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <set>

#include "preprocess/job.h"
#include "preprocess/on_threads.h"

namespace mote::prep {
namespace {

std::vector<Column> wantedColumns(const PlotAxes& axes) {
    std::set<Column> columns{Column::weight};
    for (const auto& axis : axes) columns.insert(axis.columns().begin(), axis.columns().end());
    return {columns.begin(), columns.end()};
}

bool isLost(const ParticleChunk& chunk, std::size_t i) {
    return i < chunk.lost.size() && chunk.lost[i] != 0;
}

bool isWeight(double weight) {
    return std::isfinite(weight) && weight >= 0.0;
}

/// Weights times values of a block, and the weights. Coordinates are counted from the first of them, so that
/// a bunch far from 0 loses nothing.
struct MeanSum {
    double from = 0.0;
    double product = 0.0;
    double weight = 0.0;

    void add(double value, double times) {
        product += times * (value - from);
        weight += times;
    }
};

/// Of the coordinates, and of |p|.
struct MeanSums {
    std::array<MeanSum, 8> of;
};
constexpr std::size_t momentumSum = 7;

template <class Value>
MeanSum meanSum(const ParticleChunk& chunk, bool fromFirst, Value value) {
    MeanSum sum;
    for (std::size_t i = 0; i < chunk.size; ++i) {
        const double weight = chunk[Column::weight][i];
        if (isLost(chunk, i) || !std::isfinite(value(i)) || !isWeight(weight)) continue;
        if (fromFirst && sum.weight == 0.0) sum.from = value(i);
        sum.add(value(i), weight);
    }
    return sum;
}

MeanSums meanSums(const ParticleChunk& chunk, const std::vector<Column>& columns) {
    MeanSums sums;
    for (const auto column : columns) {
        const auto at = static_cast<std::size_t>(column);
        if (at < momentumSum)
            sums.of[at] = meanSum(chunk, true, [&](std::size_t i) { return chunk[column][i]; });
    }
    if (!std::ranges::includes(columns, std::array{Column::px, Column::py, Column::pz})) return sums;
    sums.of[momentumSum] = meanSum(chunk, false, [&](std::size_t i) {
        return std::hypot(chunk[Column::px][i], chunk[Column::py][i], chunk[Column::pz][i]);
    });
    return sums;
}

/// The mean over blocks, in their order; NaN if none has weight.
double meanOf(const std::vector<MeanSum>& blocks) {
    MeanSum total;
    for (const auto& block : blocks) {
        if (!(block.weight > 0.0)) continue;
        if (total.weight == 0.0) total.from = block.from;
        total.product += block.product + block.weight * (block.from - total.from);
        total.weight += block.weight;
    }
    return total.from + total.product / total.weight;
}

}  // namespace

/// A block on its way; its memory serves block after block.
struct StepReader::Slot {
    std::size_t index = 0;
    bool isKept = false, isRead = false;
    ParticleChunk chunk;
    ParticleBlock block;

    void collect(const PlotAxes& axes, const BeamContext& context) {
        const std::size_t size = chunk.size;
        // Derived axes first: what is a column of the source changes places with it.
        for (std::size_t a = 0; a < 3; ++a) {
            if (isMoved(axes[a])) continue;
            block.coordinate[a].resize(size);
            axes[a].evaluate(chunk, context, block.coordinate[a]);
        }
        for (std::size_t a = 0; a < 3; ++a) {
            if (isMoved(axes[a])) block.coordinate[a].swap(chunk[axes[a].columns().front()]);
            block.coordinate[a].resize(size);
        }
        block.weight.swap(chunk[Column::weight]);
        block.weight.resize(size);
        block.row.resize(size);
        std::iota(block.row.begin(), block.row.end(), static_cast<std::uint32_t>(chunk.begin));
        block.lost = 0;
        block.invalid = 0;
        if (!allTakePart()) dropOthers();
    }

  private:
    /// The weight is needed besides.
    static bool isMoved(const PlotAxis& axis) {
        return axis.isColumn() && axis.columns().front() != Column::weight;
    }
    bool isValid(std::size_t i) const {
        return std::isfinite(block.coordinate[0][i]) && std::isfinite(block.coordinate[1][i]) &&
               std::isfinite(block.coordinate[2][i]) && isWeight(block.weight[i]);
    }

    /// The usual case, without a branch for each particle.
    bool allTakePart() const {
        bool all = true;
        for (const auto lost : chunk.lost) all &= lost == 0;
        for (std::size_t i = 0; i < chunk.size; ++i) all &= isValid(i);
        return all;
    }

    void dropOthers() {
        std::size_t size = 0;
        for (std::size_t i = 0; i < chunk.size; ++i) {
            if (isLost(chunk, i)) {
                ++block.lost;
            } else if (!isValid(i)) {
                ++block.invalid;
            } else {
                for (auto& coordinate : block.coordinate) coordinate[size] = coordinate[i];
                block.weight[size] = block.weight[i];
                block.row[size] = block.row[i];
                ++size;
            }
        }
        for (auto& coordinate : block.coordinate) coordinate.resize(size);
        block.weight.resize(size);
        block.row.resize(size);
    }
};

StepReader::StepReader(ParticleSource& source, std::size_t step, const PlotAxes& axes,
                       const Progress& progress)
    : source_(&source), step_(step), axes_(&axes), progress_(&progress) {}

StepReader::StepReader(StepReader&&) noexcept = default;
StepReader::~StepReader() = default;

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
    constexpr std::uint64_t particleBytes = 4 * sizeof(double) + sizeof(std::uint32_t);
    const std::size_t blocks = (info.particles + blockRows - 1) / blockRows;
    const auto size = static_cast<std::size_t>(ranks.size());
    const auto rank = static_cast<std::size_t>(ranks.rank());
    reader.first_ = blocks * rank / size;
    reader.kept_.resize(blocks * (rank + 1) / size - reader.first_);
    reader.keeps_ = reader.kept_.size() * blockRows * particleBytes <= mayKeep;
    reader.context_ = contextOf(source);
    if (std::ranges::any_of(axes, &PlotAxis::needsMeans)) MOTE_RETURN_IF_ERROR(reader.findMeans(ranks));
    return reader;
}

Status StepReader::readBlock(std::size_t index, const std::vector<Column>& wanted, ParticleChunk& chunk) {
    if (progress_->cancelled()) return wasCancelled();
    const std::uint64_t begin = (first_ + index) * blockRows;
    const auto count = static_cast<std::size_t>(std::min(blockRows, rows_ - begin));
    MOTE_RETURN_IF_ERROR(source_->read(step_, begin, count, wanted, chunk));
    MOTE_CHECK(chunk.size == count);
    for (const auto column : wanted) MOTE_CHECK(chunk[column].size() >= count);
    return success();
}

/// Weighted means over the live particles of all ranks, block by block in their order.
Status StepReader::findMeans(Communicator& ranks) {
    const auto wanted = wantedColumns(*axes_);
    std::vector<MeanSums> sums;
    ParticleChunk chunk;
    Status status = success();
    for (std::size_t index = 0; index < blockCount() && status.ok(); ++index) {
        status = readBlock(index, wanted, chunk);
        if (status.ok()) sums.push_back(meanSums(chunk, wanted));
    }
    MOTE_RETURN_IF_ERROR(agree(ranks, status));
    MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<MeanSums>(ranks, sums));
    for (std::size_t i = 0; i <= momentumSum; ++i) {
        std::vector<MeanSum> blocks;
        for (const auto& ofRank : all) {
            for (const auto& block : ofRank) blocks.push_back(block.of[i]);
        }
        (i == momentumSum ? context_.meanMomentum : context_.mean[i]) = meanOf(blocks);
    }
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
    while (slots_.size() < std::min(tokens, end - begin)) slots_.push_back(std::make_unique<Slot>());
    tbb::concurrent_bounded_queue<Slot*> free;
    for (auto& slot : slots_) free.push(slot.get());
    const bool atOnce = source_->readsAtOnce(step_);
    FirstError failed;
    std::atomic<bool> stopped{false};
    std::size_t next = begin;
    const auto read = [&](Slot& slot) {
        if (slot.isKept) return true;
        const auto status = readBlock(slot.index, wanted, slot.chunk);
        if (status.ok()) return true;
        failed.set(status.error());
        stopped = true;
        return false;
    };
    const auto take = [&](tbb::flow_control& control) -> Slot* {
        Slot* slot = nullptr;
        if (next != end && !stopped) {
            free.pop(slot);
            slot->index = next++;
            slot->isKept = kept_[slot->index].has_value();
            slot->isRead = atOnce || read(*slot);
            if (slot->isRead) return slot;
        }
        control.stop();
        return nullptr;
    };
    const auto work = [&](Slot* slot) {
        slot->isRead = !atOnce || read(*slot);
        if (!slot->isRead) return slot;
        if (slot->isKept) {
            use(*kept_[slot->index], slot->index);
        } else {
            slot->collect(*axes_, context_);
            use(slot->block, slot->index);
        }
        return slot;
    };
    const auto giveBack = [&](Slot* slot) {
        if (slot->isRead && !slot->isKept && keeps_) keep(slot->index, *slot);
        free.push(slot);
    };
    tbb::parallel_pipeline(
        slots_.size(), tbb::make_filter<void, Slot*>(tbb::filter_mode::serial_in_order, take) &
                           tbb::make_filter<Slot*, Slot*>(tbb::filter_mode::parallel, work) &
                           tbb::make_filter<Slot*, void>(tbb::filter_mode::serial_out_of_order, giveBack));
    return failed.status();
}

}  // namespace mote::prep
