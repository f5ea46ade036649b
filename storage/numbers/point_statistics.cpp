// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/task_arena.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "storage/beam/beam_rims.h"
#include "storage/beam/beam_statistics.h"
#include "storage/numbers/bin_axis.h"
#include "storage/numbers/chosen_kernel.h"
#include "storage/numbers/point_mask.h"
#include "storage/numbers/point_statistics.h"
#include "storage/numbers/run_steps.h"
#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

/// Brings the chosen points of a step, as rows of coordinates and weight, to whoever sums them, group
/// by group, in blocks that do not depend on the number of threads. Immutable; walk() uses all threads of the
/// calling arena.
class RowWalk {
  public:
    /// What takes rows of a group; called on several threads at once, with their number.
    using Take = std::function<void(std::size_t thread, std::uint32_t group, const BeamRows& rows)>;

    /// `groups`: each point goes to the group of its bin, and those without a bin to none; null: all are one
    /// group. `chosen`: null: all. `quantities`: these, one or two, take the places of x and y, and there are
    /// no other coordinates; null: those of the columns. All outlive this.
    RowWalk(const ParticleColumns& columns, const PointMask* chosen, const BinAxis* groups,
            const QuantityReader* quantities = nullptr);

    std::uint64_t points() const { return chosen_ != nullptr ? chosen_->count() : columns_.pointCount(); }
    std::uint32_t groups() const { return groups_ != nullptr ? groups_->bins() : 1; }
    /// Of the numbers that `take` is called with.
    static std::size_t threads();
    /// The rows of a part of the points have its number as their block. False where `cancelled` said to stop.
    /// Throws StorageError.
    bool walk(const std::function<bool()>& cancelled, const Take& take) const;
    /// Numbers of blocks are less.
    std::uint64_t parts() const { return std::min(mostParts, blockCount(columns_.pointCount())); }
    /// Some of the points, whatever their groups; the same for any number of threads. Nothing where
    /// `cancelled` said to stop. Throws StorageError.
    std::optional<std::vector<BeamSample>> sample(const std::function<bool()>& cancelled) const;

  private:
    static constexpr std::uint64_t mostParts = 64;
    static constexpr std::size_t columnsOfRow = BeamRows::coordinates + 1;  // and weight
    class Buffer;
    class Part;
    class Sampled;

    /// Calls `work(part, next)` on all threads, where `next()` gives the part's blocks, one after another.
    template <class Work>
    bool forParts(const std::function<bool()>& cancelled, const Work& work) const;

    const ParticleColumns& columns_;
    const PointMask* const chosen_;
    const BinAxis* const groups_;
    const QuantityReader* const quantities_;
    std::array<std::optional<std::size_t>, columnsOfRow> sources_;  ///< columns, or which of the quantities
};

// The points are cut into parts. Within one, the rows of each group are gathered until they fill a block:
// which rows are in which block depends on nothing but the points.
constexpr std::size_t blockRows = 4096;  // of one group
constexpr std::size_t groupRows = 512;   // of one of several
constexpr std::size_t pointsTogether = 512;
constexpr std::array<const char*, BeamRows::coordinates + 1> names{"x",  "y",  "z",  "t",
                                                                   "px", "py", "pz", "weight"};

/// A column of the block, as it lies in the file.
class Stored {
  public:
    static Stored of(const ParticleColumns& columns, std::size_t column, PointRange block) {
        const auto& info = columns.columns()[column];
        Stored stored;
        stored.offset = info.offset;
        if (info.doubles)
            stored.doubles = columns.doubles(column, block.begin, block.count);
        else
            stored.floats = columns.values(column, block.begin, block.count);
        return stored;
    }

    double offset = 0.0;
    std::span<const float> floats;
    std::span<const double> doubles;  ///< instead

    double at(std::size_t i) const {
        return doubles.empty() ? offset + static_cast<double>(floats[i]) : doubles[i];
    }
    /// Asks memory for values that come next: by turns of columns it does not see them coming.
    void expect(std::size_t begin, std::size_t count) const {
        expect(floats, begin, count);
        expect(doubles, begin, count);
    }

  private:
    template <class T>
    static void expect(std::span<const T> values, std::size_t begin, std::size_t count) {
        constexpr std::size_t line = 64 / sizeof(T);
        for (std::size_t i = begin; i < std::min(begin + count, values.size()); i += line)
            __builtin_prefetch(values.data() + i);
    }
};

/// Rows of one group that are not yet a block.
class RowWalk::Buffer {
  public:
    void take(std::size_t thread, std::uint32_t group, const RowWalk& walk, const Take& take,
              std::uint64_t part) {
        if (size_ == 0) return;
        BeamRows rows;
        for (std::size_t c = 0; c < columnsOfRow; ++c) {
            if (!walk.sources_[c]) continue;
            const auto values = std::span<const double>(columns_[c]).first(size_);
            (c < BeamRows::coordinates ? rows.coordinate[c] : rows.weight) = values;
        }
        rows.size = size_;
        rows.block = part;
        take(thread, group, rows);
        size_ = 0;
    }

    std::array<std::vector<double>, columnsOfRow> columns_;
    std::size_t size_ = 0;
};

RowWalk::RowWalk(const ParticleColumns& columns, const PointMask* chosen, const BinAxis* groups,
                 const QuantityReader* quantities)
    : columns_(columns), chosen_(chosen), groups_(groups), quantities_(quantities) {
    sources_.back() = columns.find(names.back());
    for (std::size_t c = 0; c + 1 < columnsOfRow; ++c) {
        if (quantities == nullptr) sources_[c] = columns.find(names[c]);
        if (quantities != nullptr && c < quantities->size()) sources_[c] = c;
    }
}

std::size_t RowWalk::threads() {
    return static_cast<std::size_t>(std::max(1, tbb::this_task_arena::max_concurrency())) + 1;
}

/// A part of the points, on one thread.
class RowWalk::Part {
  public:
    Part(const RowWalk& walk, const Take& take, std::uint64_t part, std::size_t thread)
        : walk_(walk),
          take_(take),
          part_(part),
          thread_(thread),
          capacity_(walk.groups() > 1 ? groupRows : blockRows),
          buffers_(walk.groups()) {}

    void add(PointRange block) {
        if (walk_.chosen_ != nullptr) {
            words_ = std::span(walk_.chosen_->words())
                         .subspan(block.begin / PointMask::wordBits, wordCount(block.count));
            if (!anyChosen(words_)) return;
        }
        if (walk_.quantities_ != nullptr) lookAtQuantities(block);
        for (std::size_t c = walk_.quantities_ != nullptr ? columnsOfRow - 1 : 0; c < columnsOfRow; ++c) {
            if (walk_.sources_[c]) stored_[c] = Stored::of(walk_.columns_, *walk_.sources_[c], block);
        }
        if (walk_.groups_ == nullptr) return addAll(block);
        bins_.resize(block.count);
        walk_.groups_->find(block, scratch_, bins_);
        const auto one = [&](std::size_t i) {
            if (bins_[i] < walk_.groups()) addOne(buffers_[bins_[i]], bins_[i], i);
        };
        if (walk_.chosen_ != nullptr) {
            forEachChosen(words_, one);
        } else {
            for (std::size_t i = 0; i < block.count; ++i) one(i);
        }
    }

    void finish() {
        for (std::uint32_t group = 0; group < buffers_.size(); ++group)
            buffers_[group].take(thread_, group, walk_, take_, part_);
    }

  private:
    void lookAtQuantities(PointRange block) {
        std::vector<std::span<double>> out;
        for (std::size_t c = 0; c < walk_.quantities_->size(); ++c) {
            made_[c].resize(block.count);
            out.emplace_back(made_[c]);
            stored_[c].doubles = made_[c];
        }
        walk_.quantities_->read(block.begin, block.count, quantityScratch_, out);
    }

    void reserve(Buffer& buffer) const {
        for (std::size_t c = 0; c < columnsOfRow; ++c) {
            if (walk_.sources_[c] && buffer.columns_[c].empty())
                buffer.columns_[c].resize(capacity_ + roomBehindChosen);
        }
    }

    void addOne(Buffer& buffer, std::uint32_t group, std::size_t i) {
        reserve(buffer);
        for (std::size_t c = 0; c < columnsOfRow; ++c) {
            if (walk_.sources_[c]) buffer.columns_[c][buffer.size_] = stored_[c].at(i);
        }
        if (++buffer.size_ == capacity_) buffer.take(thread_, group, walk_, take_, part_);
    }

    /// All chosen points are of one group: some at a time, column by column.
    void addAll(PointRange block) {
        auto& buffer = buffers_.front();
        reserve(buffer);
        for (std::size_t begin = 0; begin < block.count; begin += pointsTogether) {
            const auto count = std::min<std::size_t>(pointsTogether, block.count - begin);
            for (const auto& stored : stored_) stored.expect(begin + count, pointsTogether);
            std::size_t chosen = count;
            if (walk_.chosen_ != nullptr) chosen = chosenOf(begin, count);
            if (chosen == 0) continue;
            if (buffer.size_ + chosen > capacity_) buffer.take(thread_, 0, walk_, take_, part_);
            for (std::size_t c = 0; c < columnsOfRow; ++c) {
                if (walk_.sources_[c])
                    copy(stored_[c], begin, count, buffer.columns_[c].data() + buffer.size_);
            }
            buffer.size_ += chosen;
        }
    }

    std::span<const std::uint64_t> wordsOf(std::size_t begin, std::size_t count) const {
        return words_.subspan(begin / PointMask::wordBits, wordCount(count));
    }
    std::size_t chosenOf(std::size_t begin, std::size_t count) const {
        std::size_t sum = 0;
        for (const auto word : wordsOf(begin, count)) sum += static_cast<std::size_t>(std::popcount(word));
        return sum;
    }

    void copy(const Stored& from, std::size_t begin, std::size_t count, double* out) const {
        if (walk_.chosen_ == nullptr) {
            for (std::size_t i = 0; i < count; ++i) out[i] = from.at(begin + i);
        } else if (from.doubles.empty()) {
            copyChosen(from.floats.subspan(begin, count), from.offset, wordsOf(begin, count), out);
        } else {
            copyChosen(from.doubles.subspan(begin, count), wordsOf(begin, count), out);
        }
    }

    const RowWalk& walk_;
    const Take& take_;
    const std::uint64_t part_;
    const std::size_t thread_;
    const std::size_t capacity_;
    std::vector<Buffer> buffers_;           // by group
    std::span<const std::uint64_t> words_;  ///< of the block, if there is a mask
    std::vector<std::uint32_t> bins_;
    std::array<Stored, columnsOfRow> stored_;
    std::array<std::vector<double>, 2> made_;  ///< of the quantities
    QuantityReader::Scratch quantityScratch_;
    BinAxis::Scratch scratch_;
};

/// One of so many points of a part.
class RowWalk::Sampled {
  public:
    /// `rows`: of the part, or so.
    Sampled(const RowWalk& walk, std::uint64_t stride, std::uint64_t rows)
        : walk_(walk), stride_(stride), next_(stride / 2) {
        sample_.reserve(static_cast<std::size_t>(2 * rows / stride));
    }

    void add(PointRange block) {
        places_.clear();
        if (walk_.chosen_ != nullptr) {
            findChosen(block);
        } else {
            for (; next_ < block.count; next_ += stride_) places_.push_back(static_cast<std::size_t>(next_));
            next_ -= block.count;
        }
        if (places_.empty()) return;
        BeamRows rows;
        rows.size = places_.size();
        for (std::size_t c = 0; c < columnsOfRow; ++c) {
            if (!walk_.sources_[c]) continue;
            const auto stored = Stored::of(walk_.columns_, *walk_.sources_[c], block);
            values_[c].resize(places_.size());
            std::ranges::transform(places_, values_[c].begin(), [&](std::size_t i) { return stored.at(i); });
            (c < BeamRows::coordinates ? rows.coordinate[c] : rows.weight) = values_[c];
        }
        sample_.add(rows);
    }
    BeamSample take() { return std::move(sample_); }

  private:
    void findChosen(PointRange block) {
        const auto first = block.begin / PointMask::wordBits;
        for (std::size_t i = 0; i < wordCount(block.count); ++i) {
            auto word = walk_.chosen_->words()[first + i];
            const auto chosen = static_cast<std::uint64_t>(std::popcount(word));
            for (std::uint64_t passed = 0; next_ < chosen; next_ += stride_) {
                for (; passed < next_; ++passed) word &= word - 1;
                places_.push_back(i * PointMask::wordBits + static_cast<std::size_t>(std::countr_zero(word)));
            }
            next_ -= chosen;
        }
    }

    const RowWalk& walk_;
    const std::uint64_t stride_;
    std::uint64_t next_;  ///< of the chosen points from here on
    std::vector<std::size_t> places_;
    std::array<std::vector<double>, columnsOfRow> values_;
    BeamSample sample_;
};

template <class Work>
bool RowWalk::forParts(const std::function<bool()>& cancelled, const Work& work) const {
    const auto points = columns_.pointCount();
    const auto blocks = blockCount(points), parts = this->parts();
    std::atomic<bool> stop{false};
    const auto stopNow = [&] { return stop || (cancelled && cancelled()); };
    const bool whole = forBlocks(parts, stopNow, [&](std::uint64_t part) {
        auto block = part * blocks / parts;
        work(part, [&]() -> std::optional<PointRange> {
            if (block == (part + 1) * blocks / parts) return std::nullopt;
            if (stopNow()) {
                stop = true;
                return std::nullopt;
            }
            return pointsOfBlock(block++, points);
        });
    });
    return whole && !stop;
}

bool RowWalk::walk(const std::function<bool()>& cancelled, const Take& take) const {
    return forParts(cancelled, [&](std::uint64_t index, const auto& next) {
        const auto thread =
            static_cast<std::size_t>(std::max(0, tbb::this_task_arena::current_thread_index()));
        Part part(*this, take, index, thread);
        while (const auto block = next()) part.add(*block);
        part.finish();
    });
}

std::optional<std::vector<BeamSample>> RowWalk::sample(const std::function<bool()>& cancelled) const {
    std::vector<BeamSample> parts(static_cast<std::size_t>(this->parts()));
    const auto points = this->points(), stride = BeamSample::strideOf(points);
    if (!forParts(cancelled, [&](std::uint64_t index, const auto& next) {
            Sampled part(*this, stride, points / parts.size());
            while (const auto block = next()) part.add(*block);
            parts[index] = part.take();
        }))
        return std::nullopt;
    return parts;
}

/// The values of each group of a walk. Nothing where `cancelled` says so.
std::optional<std::vector<std::vector<double>>> valuesOf(const RowWalk& walk, const BeamFacts& facts,
                                                         Passes wanted,
                                                         const std::function<bool()>& cancelled) {
    const auto threads = RowWalk::threads();
    const auto groups = walk.groups();
    std::vector<std::vector<BeamMoments>> moments(threads,
                                                  std::vector<BeamMoments>(groups, BeamMoments(facts.mass)));
    std::vector<BeamSample> sample;
    std::optional<BeamRims> rims;
    if (wanted == Passes::percentilesToo && groups == 1) {
        auto taken = walk.sample(cancelled);
        if (!taken) return std::nullopt;
        sample = *std::move(taken);
        rims.emplace(sample, walk.points());
    }
    std::vector<BeamRims::Gathered> rimsOf(rims && rims->known() ? walk.parts() : 0);
    if (!walk.walk(cancelled, [&](std::size_t thread, std::uint32_t group, const BeamRows& rows) {
            const auto taken = moments[thread][group].add(rows);
            if (!rimsOf.empty()) rims->add(rows, taken == rows.size, rimsOf[rows.block]);
        }))
        return std::nullopt;
    std::vector<BeamMoments::Sums> totals;
    std::vector<BeamPercentiles> percentiles;
    for (std::uint32_t group = 0; group < groups; ++group) {
        for (std::size_t thread = 1; thread < threads; ++thread)
            moments[0][group].merge(moments[thread][group].blocks());
        totals.push_back(moments[0][group].total());
        percentiles.emplace_back(totals.back());
    }
    moments.clear();
    if (!rimsOf.empty() && percentiles[0].needsPass()) {
        const auto found = rims->emittances(totals[0], rimsOf);
        if (found) percentiles[0].finish(*found);
    }
    rimsOf.clear();
    if (!sample.empty() && percentiles[0].needsPass()) percentiles[0] = BeamPercentiles(totals[0], sample);
    sample.clear();
    const auto needsPass = [](const BeamPercentiles& one) { return one.needsPass(); };
    while (wanted == Passes::percentilesToo && std::ranges::any_of(percentiles, needsPass)) {
        std::vector<std::vector<BeamPercentiles::Gathered>> passes(
            threads, std::vector<BeamPercentiles::Gathered>(groups));
        if (!walk.walk(cancelled, [&](std::size_t thread, std::uint32_t group, const BeamRows& rows) {
                if (percentiles[group].needsPass()) percentiles[group].add(rows, passes[thread][group]);
            }))
            return std::nullopt;
        for (std::uint32_t group = 0; group < groups; ++group) {
            if (!percentiles[group].needsPass()) continue;
            for (std::size_t thread = 1; thread < threads; ++thread)
                passes[0][group].merge(std::exchange(passes[thread][group], {}));
            percentiles[group].finishPass(std::move(passes[0][group]));
        }
    }
    std::vector<std::vector<double>> values;
    for (std::uint32_t group = 0; group < groups; ++group)
        values.push_back(beamValues(totals[group], percentiles[group], facts));
    return values;
}

/// One of them in each group: the quantities take the places of x and y. Nothing where `cancelled` says so.
Result<std::optional<std::vector<double>>> furtherOf(const QuantityStatistic& statistic,
                                                     const StepNumbers& step, const PointMask* chosen,
                                                     const BinAxis* groups,
                                                     const std::function<bool()>& cancelled) {
    MOTE_ASSIGN_OR_RETURN(const auto reader,
                          QuantityReader::make(*step.columns, step.context, statistic.quantities));
    const auto all =
        valuesOf(RowWalk(*step.columns, chosen, groups, &reader), {}, Passes::momentsAlone, cancelled);
    if (!all) return std::optional<std::vector<double>>();
    const auto place = statistic.quantities.size() == 2 ? "cov_x__y" : fmt::format("{}_x", statistic.kind);
    std::vector<double> values;
    for (const auto& group : *all) values.push_back(group[*findStatistic(place)]);
    return std::optional(std::move(values));
}

/// Adds them to the values of each group.
Status addFurther(FurtherStatistics further, const StepNumbers& step, const PointMask* chosen,
                  const BinAxis* groups, const std::function<bool()>& cancelled,
                  std::span<std::vector<double>> to) {
    for (const auto& statistic : further) {
        MOTE_ASSIGN_OR_RETURN(const auto values, furtherOf(statistic, step, chosen, groups, cancelled));
        if (!values) return wasCancelled();
        for (std::size_t i = 0; i < to.size(); ++i) to[i].push_back((*values)[i]);
    }
    return success();
}

/// The least and the greatest finite value of the chosen points. Nothing where `cancelled` says so.
std::optional<std::pair<double, double>> rangeOf(const QuantityReader& reader, std::uint64_t points,
                                                 const PointMask* chosen,
                                                 const std::function<bool()>& cancelled) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    std::vector<std::pair<double, double>> ranges(blockCount(points), {infinite, -infinite});
    const bool whole = forBlocks(ranges.size(), cancelled, [&](std::uint64_t block) {
        const auto part = pointsOfBlock(block, points);
        std::vector<double> values(part.count);
        QuantityReader::Scratch scratch;
        const std::array out{std::span(values)};
        reader.read(part.begin, part.count, scratch, out);
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (!std::isfinite(values[i]) || (chosen != nullptr && !chosen->chosen(part.begin + i))) continue;
            ranges[block].first = std::min(ranges[block].first, values[i]);
            ranges[block].second = std::max(ranges[block].second, values[i]);
        }
    });
    if (!whole) return std::nullopt;
    std::pair all{infinite, -infinite};
    for (const auto& [low, high] : ranges) all = {std::min(all.first, low), std::max(all.second, high)};
    return widened(all.first, all.second);
}

/// Errors: cancelled.
Result<BinAxis> binsOf(const SlicesWanted& slices, const StepNumbers& step, const QuantityReader& reader,
                       const std::pair<double, double>& range, const PointMask* chosen,
                       const std::function<bool()>& cancelled) {
    if (slices.of == SlicesWanted::Of::even)
        return BinAxis::make(step, slices.column, slices.count, range.first, range.second);
    auto edges = edgesOfEqualWeight(step, reader, chosen, slices.count, range.first, range.second, cancelled);
    if (!edges) return wasCancelled();
    return BinAxis::make(step, slices.column, *std::move(edges));
}

}  // namespace

Result<PointStatistics> pointStatistics(const StepNumbers& step, const BeamFacts& facts,
                                        const PointMask* chosen, const std::optional<SlicesWanted>& slices,
                                        Passes passes, const std::function<bool()>& cancelled,
                                        FurtherStatistics further) {
    const auto& columns = *step.columns;
    PointStatistics found;
    auto all = valuesOf(RowWalk(columns, chosen, nullptr), facts, passes, cancelled);
    if (!all) return wasCancelled();
    MOTE_RETURN_IF_ERROR(addFurther(further, step, chosen, nullptr, cancelled, *all));
    found.values = std::move(all->front());
    if (slices) {
        const auto reader = QuantityReader::make(columns, step.context, std::span(&slices->column, 1));
        if (!reader.ok()) {
            const auto& error = reader.error();  // at the name
            return Error{error.code, "slices", fmt::format("\"{}\" {}", error.where, error.message)};
        }
        const auto range = rangeOf(*reader, columns.pointCount(), chosen, cancelled);
        if (!range) return wasCancelled();
        MOTE_ASSIGN_OR_RETURN(const auto bins, binsOf(*slices, step, *reader, *range, chosen, cancelled));
        BeamFacts ofSlice = facts;
        ofSlice.lost = 0;
        auto parts = valuesOf(RowWalk(columns, chosen, &bins), ofSlice, passes, cancelled);
        if (!parts) return wasCancelled();
        MOTE_RETURN_IF_ERROR(addFurther(further, step, chosen, &bins, cancelled, *parts));
        found.edges = bins.edges();
        found.slices = *std::move(parts);
    }
    columns.check();
    return found;
}

}  // namespace mote::storage
