// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/step_statistics.h"

#include <oneapi/tbb/concurrent_queue.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "preprocess/on_threads.h"
#include "protocol/base/mote_check.h"
#include "storage/beam/beam_statistics.h"
#include "storage/beam/neutral_species.h"

namespace mote::prep {
namespace {

using storage::BeamMoments;
using storage::BeamPercentiles;
using storage::BeamRows;

constexpr std::array<Column, BeamRows::coordinates> coordinates{Column::x,  Column::y,  Column::z, Column::t,
                                                                Column::px, Column::py, Column::pz};

/// How many of a chunk take part, and how many its source marks as lost.
struct Parts {
    std::size_t live = 0;
    std::uint64_t lost = 0;
};

/// Those of a chunk that take part.
struct Live {
    ParticleChunk chunk;
    Parts parts;
};

std::vector<Column> united(std::vector<Column> columns, const std::vector<Column>& others) {
    for (const auto column : others) {
        if (std::ranges::find(columns, column) == columns.end()) columns.push_back(column);
    }
    return columns;
}

}  // namespace

/// Over the rows of a step.
class StepStatistics::Passes {
  public:
    explicit Passes(const StatisticsRequest& request)
        : request_(request), source_(*request.source), ranks_(*request.ranks) {
        for (const auto column : coordinates) {
            if (source_.has(column)) wanted_.push_back(column);
        }
        wanted_.push_back(Column::weight);
        read_ = united(wanted_, request.observed);
        const std::uint64_t rows = source_.steps()[request.step].particles;
        const std::uint64_t chunks = (rows + rowsOfChunk - 1) / rowsOfChunk;
        const auto size = static_cast<std::uint64_t>(ranks_.size());
        const auto rank = static_cast<std::uint64_t>(ranks_.rank());
        begin_ = std::min(rows, chunks * rank / size * rowsOfChunk);
        end_ = std::min(rows, chunks * (rank + 1) / size * rowsOfChunk);
        const std::uint64_t bytes = (end_ - begin_) * wanted_.size() * sizeof(double);
        // More in fresh memory takes longer than to read it again, the more so if all threads read.
        const std::uint64_t mostKept = std::uint64_t{1} << (source_.readsAtOnce(request.step) ? 27 : 30);
        keeps_ = bytes <= std::min(request.memory / 4, mostKept);
        if (keeps_) kept_.resize((end_ - begin_ + rowsOfChunk - 1) / rowsOfChunk);
    }

    /// Reads all rows once, for who observes them, and no more of them.
    Status look() {
        if (!request_.observe) return success();
        return agree(ranks_, forEachChunk(source_, request_.step, begin_, end_,
                                          united({Column::weight}, request_.observed), *request_.progress,
                                          request_.observe));
    }

    Status sum() {
        MOTE_ASSIGN_OR_RETURN(total_, findMoments());
        percentiles_.emplace(total_);
        return success();
    }

    Status findPercentiles() {
        while (percentiles_->needsPass()) MOTE_RETURN_IF_ERROR(pass(*percentiles_));
        return success();
    }

    /// Whether what was read is in memory.
    bool keeps() const { return keeps_; }

    std::vector<double> values() const {
        storage::BeamFacts facts;
        facts.mass = source_.mass();
        facts.particleCharge = source_.particleCharge();
        facts.neutral = storage::isNeutral(source_.species());
        facts.weightUnit = source_.weightUnit();
        facts.lost = lost_;
        return storage::beamValues(total_, *percentiles_, facts);
    }

  private:
    /// Calls `use` for each chunk of this rank, from all threads.
    Status forEach(const std::function<void(const BeamRows&, const Parts&)>& use) {
        if (keeps_ && haveKept_) {
            tbb::parallel_for(std::size_t{0}, kept_.size(), [&](std::size_t i) {
                if (!request_.progress->cancelled())
                    use(rowsOf(kept_[i].chunk, kept_[i].parts.live), kept_[i].parts);
            });
            return request_.progress->cancelled() ? Status(wasCancelled()) : success();
        }
        tbb::enumerable_thread_specific<Live> scratch;
        const auto take = [&](const ParticleChunk& chunk) {
            if (!observed_ && request_.observe) request_.observe(chunk);
            const auto parts = partsOf(chunk);
            if (!keeps_ && parts.live == chunk.size) return use(rowsOf(chunk, chunk.size), parts);
            auto& live = keeps_ ? kept_[(chunk.begin - begin_) / rowsOfChunk] : scratch.local();
            live.parts = parts;
            collect(chunk, live);
            use(rowsOf(live.chunk, parts.live), parts);
        };
        MOTE_RETURN_IF_ERROR(
            forEachChunk(source_, request_.step, begin_, end_, read_, *request_.progress, take));
        haveKept_ = observed_ = true;
        return success();
    }

    Parts partsOf(const ParticleChunk& chunk) const {
        const auto marks = std::span(chunk.lost).first(std::min(chunk.lost.size(), chunk.size));
        const auto lost = marks.size() - static_cast<std::size_t>(std::ranges::count(marks, 0));
        return {(takesPart(request_.lost, true) ? lost : 0) +
                    (takesPart(request_.lost, false) ? chunk.size - lost : 0),
                lost};
    }

    void collect(const ParticleChunk& chunk, Live& live) const {
        const auto marked = [&](std::size_t i) { return i < chunk.lost.size() && chunk.lost[i] != 0; };
        live.chunk.begin = chunk.begin;
        for (const auto column : wanted_) {
            auto& to = live.chunk[column];
            const auto& from = chunk[column];
            to.resize(live.parts.live);
            if (live.parts.live == chunk.size) {
                std::copy_n(from.begin(), chunk.size, to.begin());
                continue;
            }
            std::size_t next = 0;
            for (std::size_t i = 0; i < chunk.size; ++i) {
                if (takesPart(request_.lost, marked(i))) to[next++] = from[i];
            }
        }
    }

    BeamRows rowsOf(const ParticleChunk& chunk, std::size_t size) const {
        BeamRows rows;
        rows.block = chunk.begin / rowsOfChunk;
        rows.size = size;
        for (std::size_t c = 0; c < coordinates.size(); ++c) {
            if (source_.has(coordinates[c]))
                rows.coordinate[c] = std::span(chunk[coordinates[c]]).first(size);
        }
        rows.weight = std::span(chunk[Column::weight]).first(size);
        return rows;
    }

    Result<BeamMoments::Sums> findMoments() {
        struct Part {
            BeamMoments moments;
            std::uint64_t lost = 0;
        };
        tbb::enumerable_thread_specific<Part> parts([&] { return Part{BeamMoments(source_.mass()), 0}; });
        const auto status = forEach([&](const BeamRows& rows, const Parts& of) {
            auto& part = parts.local();
            part.moments.add(rows);
            part.lost += of.lost;
        });
        MOTE_RETURN_IF_ERROR(agree(ranks_, status));
        BeamMoments mine(source_.mass());
        std::uint64_t lost = 0;
        for (const auto& part : parts) {
            mine.merge(part.moments.blocks());
            lost += part.lost;
        }
        MOTE_ASSIGN_OR_RETURN(const auto blocks, shareValues<BeamMoments::Sums>(ranks_, mine.blocks()));
        MOTE_ASSIGN_OR_RETURN(const auto marks,
                              shareValues<std::uint64_t>(ranks_, std::span<const std::uint64_t>(&lost, 1)));
        BeamMoments all(source_.mass());
        for (const auto& part : blocks) all.merge(part);
        for (const auto& part : marks) lost_ += part.front();
        return all.total();
    }

    Status pass(BeamPercentiles& percentiles) {
        tbb::enumerable_thread_specific<BeamPercentiles::Gathered> parts;
        const auto status =
            forEach([&](const BeamRows& rows, const Parts&) { percentiles.add(rows, parts.local()); });
        MOTE_RETURN_IF_ERROR(agree(ranks_, status));
        BeamPercentiles::Gathered mine;
        for (const auto& part : parts) mine.merge(part);
        MOTE_ASSIGN_OR_RETURN(const auto bins, shareValues<BeamPercentiles::Bin>(ranks_, mine.bins));
        MOTE_ASSIGN_OR_RETURN(const auto sums, shareValues<BeamPercentiles::BlockSums>(ranks_, mine.sums));
        MOTE_ASSIGN_OR_RETURN(const auto near, shareValues<BeamPercentiles::NearCut>(ranks_, mine.near));
        BeamPercentiles::Gathered all;
        for (std::size_t rank = 0; rank < bins.size(); ++rank) {
            all.merge({bins[rank], sums[rank], near[rank]});
        }
        percentiles.finishPass(std::move(all));
        return success();
    }

    const StatisticsRequest& request_;
    ParticleSource& source_;
    Communicator& ranks_;
    std::vector<Column> wanted_, read_;  ///< for sums; and what is read with them
    std::uint64_t begin_ = 0, end_ = 0;  ///< rows of this rank
    bool keeps_ = false, haveKept_ = false, observed_ = false;
    std::vector<Live> kept_;  ///< by chunk
    std::uint64_t lost_ = 0;
    BeamMoments::Sums total_;
    std::optional<BeamPercentiles> percentiles_;
};

Status forEachChunk(ParticleSource& source, std::size_t step, std::uint64_t begin, std::uint64_t end,
                    const std::vector<Column>& wanted, const Progress& progress,
                    const std::function<void(const ParticleChunk&)>& use) {
    std::vector<ParticleChunk> chunks(2 * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()));
    tbb::concurrent_bounded_queue<ParticleChunk*> free;
    for (auto& chunk : chunks) free.push(&chunk);
    const bool atOnce = source.readsAtOnce(step);
    FirstError failed;
    std::atomic<bool> stopped{false};
    std::uint64_t next = begin;
    const auto read = [&](ParticleChunk& chunk) {
        const auto count = chunk.size;
        const auto status = source.read(step, chunk.begin, count, wanted, chunk);
        MOTE_CHECK(!status.ok() || chunk.size == count);
        if (status.ok()) return true;
        failed.set(status.error());
        stopped = true;
        return false;
    };
    const auto take = [&](tbb::flow_control& control) -> ParticleChunk* {
        if (next < end && !stopped && progress.cancelled()) {
            failed.set(wasCancelled());
            stopped = true;
        }
        ParticleChunk* chunk = nullptr;
        if (next < end && !stopped) {
            free.pop(chunk);
            chunk->begin = next;
            chunk->size = static_cast<std::size_t>(std::min(rowsOfChunk, end - next));
            next += chunk->size;
            if (atOnce || read(*chunk)) return chunk;
        }
        control.stop();
        return nullptr;
    };
    const auto work = [&](ParticleChunk* chunk) {
        if (!atOnce || read(*chunk)) use(*chunk);
        free.push(chunk);
    };
    tbb::parallel_pipeline(chunks.size(),
                           tbb::make_filter<void, ParticleChunk*>(tbb::filter_mode::serial_in_order, take) &
                               tbb::make_filter<ParticleChunk*, void>(tbb::filter_mode::parallel, work));
    return failed.status();
}

StepStatistics::StepStatistics(StatisticsRequest request) : request_(std::move(request)) {}
StepStatistics::~StepStatistics() = default;

Status StepStatistics::begin() {
    values_ = request_.source->statistics(request_.step);
    auto passes = std::make_unique<Passes>(request_);
    if (!values_.empty()) return passes->look();
    MOTE_RETURN_IF_ERROR(passes->sum());
    values_ = passes->values();
    // What is kept takes memory until then; ranks, some of which keep it, go together.
    const bool now = passes->keeps() || request_.ranks->size() > 1;
    passes_ = std::move(passes);
    return now ? finish() : success();
}

Status StepStatistics::finish() {
    const auto passes = std::move(passes_);
    if (!passes) return success();
    MOTE_RETURN_IF_ERROR(passes->findPercentiles());
    values_ = passes->values();
    return success();
}

}  // namespace mote::prep
