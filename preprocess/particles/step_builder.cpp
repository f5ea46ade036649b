// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/step_builder.h"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <numeric>
#include <span>

#include "preprocess/job.h"
#include "preprocess/on_threads.h"
#include "preprocess/particles/cell_plan.h"
#include "preprocess/particles/range_builder.h"

namespace mote::prep {
namespace {

/// The particles of a rank's ranges.
struct SortedParticles {
    RecordStore particles;
    RecordStore weights;  ///< doubles; empty where all particles have the same
};

/// Alone, more, so that reading rarely waits; with others, fewer, whose messages find memory that is warm.
std::size_t blocksPerRound(const Communicator& ranks) {
    return ranks.size() == 1 ? 16 : 4;
}

class ParticleExchange {
  public:
    /// All references outlive this.
    ParticleExchange(const CellPlan& plan, Communicator& ranks, bool withWeights)
        : plan_(plan), ranks_(ranks), withWeights_(withWeights) {
        assignRanges();
    }

    /// Each rank's first range, and one more.
    const std::vector<std::size_t>& firstRange() const { return firstRange_; }

    /// `cells`: this rank's particles by cell of the grid. `store` has room for those of its ranges. Errors:
    /// the source's own, resourceExhausted (disk full), cancelled; the same on all ranks.
    Status run(StepReader& reader, const std::array<Range, 3>& bounds,
               const std::vector<std::uint32_t>& cells, SortedParticles& store) {
        MOTE_RETURN_IF_ERROR(findPlaces(cells));
        MOTE_ASSIGN_OR_RETURN(const auto rounds, findRounds(reader));
        tbb::enumerable_thread_specific<QuantizedBlock> blocks;
        std::vector<Batch> batches;
        const auto make = [&](std::size_t round) -> Result<std::vector<Bytes>> {
            const std::size_t together = blocksPerRound(ranks_);
            const std::size_t begin = std::min(reader.blockCount(), round * together);
            const std::size_t end = std::min(reader.blockCount(), begin + together);
            batches.resize(end - begin);
            MOTE_RETURN_IF_ERROR(reader.forEach(begin, end, [&](const ParticleBlock& block, std::size_t i) {
                auto& quantized = blocks.local();
                quantize(block, bounds, quantized);
                sortByRange(quantized, batches[i - begin]);
            }));
            return deliver(batches, store);
        };
        const auto use = [&](std::size_t, const std::vector<Bytes>& incoming) -> Status {
            for (std::size_t from = 0; from < incoming.size(); ++from) {
                if (from != own()) MOTE_RETURN_IF_ERROR(place(from, unpack(incoming[from]), store));
            }
            return success();
        };
        return exchangeInRounds(ranks_, rounds, make, use);
    }

  private:
    /// A block of rows, sorted by range.
    struct Batch {
        std::vector<std::uint32_t> counts;  ///< by range
        std::vector<Particle> particles;
        std::vector<double> weights;
    };

    /// A batch's particles of this rank's ranges, wherever they came from.
    struct Share {
        std::span<const std::uint32_t> counts;  ///< by range of this rank
        std::span<const Particle> particles;
        std::span<const double> weights;
    };

    /// Ranges in turn, so that each rank has about as many particles.
    void assignRanges() {
        const auto size = static_cast<std::size_t>(ranks_.size());
        firstRange_.push_back(0);
        for (std::size_t rank = 1; rank < size; ++rank) {
            const std::uint64_t wanted = plan_.particles() * rank / size;
            std::size_t range = firstRange_.back();
            while (range < plan_.ranges.size() && plan_.ranges[range].begin < wanted) ++range;
            firstRange_.push_back(range);
        }
        firstRange_.push_back(plan_.ranges.size());
    }

    std::size_t own() const { return static_cast<std::size_t>(ranks_.rank()); }
    std::size_t rangesOf(std::size_t rank) const { return firstRange_[rank + 1] - firstRange_[rank]; }

    /// Within a range, particles of earlier ranks come first: they are of earlier rows.
    Status findPlaces(const std::vector<std::uint32_t>& cells) {
        std::vector<std::uint32_t> mine(plan_.ranges.size());
        for (std::size_t cell = 0; cell < cells.size(); ++cell) mine[plan_.rangeOfCell[cell]] += cells[cell];
        MOTE_ASSIGN_OR_RETURN(const auto counts, shareValues<std::uint32_t>(ranks_, mine));
        const auto rank = static_cast<std::size_t>(ranks_.rank());
        next_.assign(counts.size(), std::vector<std::uint64_t>(rangesOf(rank)));
        for (std::size_t i = 0; i < rangesOf(rank); ++i) {
            const std::size_t range = firstRange_[rank] + i;
            std::uint64_t at = plan_.ranges[range].begin - plan_.ranges[firstRange_[rank]].begin;
            for (std::size_t from = 0; from < counts.size(); ++from) {
                next_[from][i] = at;
                at += counts[from][range];
            }
        }
        return success();
    }

    Result<std::size_t> findRounds(const StepReader& reader) {
        const std::size_t together = blocksPerRound(ranks_);
        const std::uint64_t mine = (reader.blockCount() + together - 1) / together;
        MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<std::uint64_t>(ranks_, std::span(&mine, 1)));
        std::uint64_t most = 0;
        for (const auto& one : all) most = std::max(most, one.front());
        return static_cast<std::size_t>(most);
    }

    void sortByRange(const QuantizedBlock& block, Batch& batch) const {
        batch.counts.assign(plan_.ranges.size(), 0);
        const auto rangeOf = [&](const Particle& particle) {
            return plan_.rangeOfCell[gridCellOf(particle, plan_.gridLevel)];
        };
        for (const auto& particle : block.particles) ++batch.counts[rangeOf(particle)];
        std::vector<std::uint32_t> next(batch.counts.size());
        std::exclusive_scan(batch.counts.begin(), batch.counts.end(), next.begin(), 0U);
        batch.particles.resize(block.particles.size());
        batch.weights.resize(withWeights_ ? block.particles.size() : 0);
        for (std::size_t i = 0; i < block.particles.size(); ++i) {
            const auto to = next[rangeOf(block.particles[i])]++;
            batch.particles[to] = block.particles[i];
            if (withWeights_) batch.weights[to] = block.weight[i];
        }
    }

    Share shareOf(const Batch& batch, std::size_t rank) const {
        const auto first = batch.counts.begin() + static_cast<std::ptrdiff_t>(firstRange_[rank]);
        const auto last = batch.counts.begin() + static_cast<std::ptrdiff_t>(firstRange_[rank + 1]);
        const std::size_t begin = std::accumulate(batch.counts.begin(), first, std::size_t{0});
        const std::size_t count = std::accumulate(first, last, std::size_t{0});
        return {{first, last},
                std::span(batch.particles).subspan(begin, count),
                withWeights_ ? std::span(batch.weights).subspan(begin, count) : std::span<const double>()};
    }

    /// Places this rank's own; returns what goes to the others.
    Result<std::vector<Bytes>> deliver(const std::vector<Batch>& batches, SortedParticles& store) {
        std::vector<Share> mine;
        mine.reserve(batches.size());
        for (const auto& batch : batches) mine.push_back(shareOf(batch, own()));
        MOTE_RETURN_IF_ERROR(place(own(), mine, store));
        std::vector<Bytes> outgoing(static_cast<std::size_t>(ranks_.size()));
        for (std::size_t rank = 0; rank < outgoing.size(); ++rank) {
            if (rank != own()) outgoing[rank] = pack(batches, rank);
        }
        return outgoing;
    }

    Status place(std::size_t from, const std::vector<Share>& shares, SortedParticles& store) {
        const std::size_t ranges = next_[from].size();
        std::vector<std::uint64_t> at;
        for (const auto& share : shares) {
            for (std::size_t range = 0; range < ranges; ++range) {
                at.push_back(next_[from][range]);
                next_[from][range] += share.counts[range];
            }
        }
        return inParallel(shares.size(), [&](std::size_t i) -> Status {
            std::size_t begin = 0;
            for (std::size_t range = 0; range < ranges; ++range) {
                const std::size_t count = shares[i].counts[range];
                const std::uint64_t to = at[i * ranges + range];
                MOTE_RETURN_IF_ERROR(store.particles.write(to, shares[i].particles.subspan(begin, count)));
                if (withWeights_)
                    MOTE_RETURN_IF_ERROR(store.weights.write(to, shares[i].weights.subspan(begin, count)));
                begin += count;
            }
            return success();
        });
    }

    Bytes pack(const std::vector<Batch>& batches, std::size_t rank) const {
        std::vector<Share> shares;
        std::size_t size = 0;
        for (const auto& batch : batches) {
            const auto& share = shares.emplace_back(shareOf(batch, rank));
            size += listBytes<std::uint32_t>(share.counts.size()) +
                    listBytes<Particle>(share.particles.size()) + listBytes<double>(share.weights.size());
        }
        Bytes bytes;
        bytes.reserve(size);
        for (const auto& share : shares) {
            addList(bytes, share.counts);
            addList(bytes, share.particles);
            addList(bytes, share.weights);
        }
        return bytes;
    }

    std::vector<Share> unpack(const Bytes& bytes) const {
        std::vector<Share> shares;
        std::span<const std::byte> rest(bytes);
        while (rest.size() > listBytes<std::byte>(0)) {
            auto& share = shares.emplace_back();
            share.counts = takeList<std::uint32_t>(rest);
            share.particles = takeList<Particle>(rest);
            share.weights = takeList<double>(rest);
        }
        return shares;
    }

    const CellPlan& plan_;
    Communicator& ranks_;
    bool withWeights_;
    std::vector<std::size_t> firstRange_;
    /// Where the next particle from a rank goes: by rank, by range of this rank.
    std::vector<std::vector<std::uint64_t>> next_;
};

template <class T>
void appendTo(std::vector<T>& to, const std::vector<T>& from) {
    to.insert(to.end(), from.begin(), from.end());
}

class Builder {
  public:
    Builder(StepReader& reader, const std::array<Range, 3>& bounds, const StepOptions& options,
            const StepResources& resources)
        : reader_(reader),
          bounds_(bounds),
          options_(options),
          resources_(resources),
          ranks_(*resources.ranks),
          gridLevel_(gridLevelFor(reader.rows())),
          rangeOptions_{options.octree, gridLevel_, std::max(gridLevel_, options.volumeLevel)} {}

    Result<BuiltStep> run() {
        MOTE_RETURN_IF_ERROR(plan());
        MOTE_RETURN_IF_ERROR(sortIntoRanges());
        MOTE_RETURN_IF_ERROR(agree(ranks_, buildRanges()));
        MOTE_RETURN_IF_ERROR(shareVolume());
        auto part = joinTrees();
        MOTE_ASSIGN_OR_RETURN(built_.octree, assembleOctree(std::move(part), ranks_));
        built_.points = std::move(store_.particles);
        return std::move(built_);
    }

  private:
    std::size_t rank() const { return static_cast<std::size_t>(ranks_.rank()); }

    Status plan() {
        auto mine = countCells(reader_, bounds_, gridLevel_);
        MOTE_RETURN_IF_ERROR(agree(ranks_, mine));
        MOTE_ASSIGN_OR_RETURN(const auto all, sumOfRanks(ranks_, *mine));
        cells_ = std::move(mine->cells);
        withWeights_ = all.weight.min < all.weight.max;
        weight_ = all.weight.min;
        plan_ = planCells(all.cells, gridLevel_, options_.octree);
        built_.counts = {plan_.particles(), all.lost, all.invalid, all.outside};
        return success();
    }

    Status sortIntoRanges() {
        ParticleExchange exchange(plan_, ranks_, withWeights_);
        const auto& firstRange = exchange.firstRange();
        for (const auto range : firstRange) {
            built_.firstPoint.push_back(range < plan_.ranges.size() ? plan_.ranges[range].begin
                                                                    : plan_.particles());
        }
        const std::size_t first = firstRange[rank()];
        firstUnit_ = first < plan_.ranges.size() ? plan_.ranges[first].firstUnit : plan_.units.size();
        ranges_ =
            std::span(plan_.ranges).subspan(firstRange[rank()], firstRange[rank() + 1] - firstRange[rank()]);
        MOTE_RETURN_IF_ERROR(agree(ranks_, makeStores()));
        return exchange.run(reader_, bounds_, cells_, store_);
    }

    Status makeStores() {
        const std::uint64_t count = built_.firstPoint[rank() + 1] - built_.firstPoint[rank()];
        const std::uint64_t bytes = count * sizeof(Particle);
        const std::uint64_t weightBytes = withWeights_ ? count * sizeof(double) : 0;
        const bool spill = bytes + weightBytes > resources_.memory;
        const auto make = [&](std::uint64_t size) {
            return spill ? RecordStore::inFile(resources_.temporary, size)
                         : RecordStore::inMemory(size, resources_.stores);
        };
        MOTE_ASSIGN_OR_RETURN(auto particles, make(bytes));
        MOTE_ASSIGN_OR_RETURN(auto weights, make(weightBytes));
        store_ = {std::move(particles), std::move(weights)};
        return success();
    }

    /// What a thread needs to build ranges.
    struct Worker {
        RangeBuilder builder;
        std::vector<Particle> particles;
        std::vector<double> weights;
        Status status = success();
    };

    Status buildRanges() {
        trees_.resize(ranges_.size());
        tbb::enumerable_thread_specific<Worker> workers;
        std::atomic<bool> failed{false};
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, ranges_.size(), 1), [&](const auto& part) {
            auto& worker = workers.local();
            for (auto i = part.begin(); i < part.end() && !failed; ++i) {
                worker.status = resources_.cancelled() ? wasCancelled() : buildRange(i, worker);
                if (!worker.status.ok()) failed = true;
            }
        });
        store_.weights = RecordStore();
        for (const auto& worker : workers) MOTE_RETURN_IF_ERROR(worker.status);
        return success();
    }

    /// Its points take the place of its particles in the store.
    Status buildRange(std::size_t i, Worker& worker) {
        const auto& range = ranges_[i];
        const std::uint64_t first = range.begin - built_.firstPoint[rank()];
        MOTE_ASSIGN_OR_RETURN(const auto particles,
                              store_.particles.read(first, range.count, worker.particles));
        Weights weights{{}, weight_};
        if (withWeights_) {
            MOTE_ASSIGN_OR_RETURN(weights.each, store_.weights.read(first, range.count, worker.weights));
        }
        const auto units = std::span(plan_.units).subspan(range.firstUnit, range.unitCount);
        trees_[i] = worker.builder.build(particles, weights, units, rangeOptions_);
        return store_.particles.write(first, worker.builder.points());
    }

    Status shareVolume() {
        std::vector<CellSum> mine;
        for (const auto& tree : trees_) appendTo(mine, tree.cells);
        MOTE_ASSIGN_OR_RETURN(const auto all, shareValues<CellSum>(ranks_, mine));
        std::vector<double> sums(std::size_t{1} << (3 * options_.volumeLevel));
        for (const auto& cells : all) addCells(cells, rangeOptions_.cellLevel, options_.volumeLevel, sums);
        built_.volumeSize = 1U << options_.volumeLevel;
        built_.volume = densityVolume(sums, options_.volumeLevel);
        return success();
    }

    /// What this rank found below the grid, and the plan's levels.
    OctreePart joinTrees() {
        OctreePart part;
        part.top = std::move(plan_.levels);
        part.units = std::move(plan_.units);
        part.firstUnit = firstUnit_;
        part.found = joined<UnitTree>([](RangeTree & tree) -> auto& { return tree.units; });
        if (options_.octree.maxLevel > gridLevel_) part.below.resize(options_.octree.maxLevel - gridLevel_);
        for (std::size_t depth = 0; depth < part.below.size(); ++depth) {
            const auto joinOne = [&]<class T>(std::vector<T> OctreeLevel::*list) {
                part.below[depth].*list =
                    joined<T>([&](RangeTree & tree) -> auto& { return tree.levels[depth].*list; });
            };
            joinOne(&OctreeLevel::children);
            joinOne(&OctreeLevel::count);
            joinOne(&OctreeLevel::weight);
        }
        trees_.clear();
        return part;
    }

    /// Of all ranges in turn the lists that `of` names, which are given up.
    template <class T, class Of>
    std::vector<T> joined(const Of& of) {
        std::vector<std::size_t> begin{0};
        for (auto& tree : trees_) begin.push_back(begin.back() + of(tree).size());
        std::vector<T> all(begin.back());
        tbb::parallel_for(std::size_t{0}, trees_.size(), [&](std::size_t i) {
            std::ranges::copy(of(trees_[i]), all.begin() + static_cast<std::ptrdiff_t>(begin[i]));
            of(trees_[i]) = {};
        });
        return all;
    }

    StepReader& reader_;
    const std::array<Range, 3>& bounds_;
    const StepOptions& options_;
    const StepResources& resources_;
    Communicator& ranks_;
    unsigned gridLevel_;
    RangeOptions rangeOptions_;
    std::vector<std::uint32_t> cells_;  ///< this rank's particles by cell
    bool withWeights_ = false;          ///< whether they differ
    double weight_ = 0.0;               ///< that of all, where they do not
    CellPlan plan_;
    std::span<const PlanRange> ranges_;  ///< this rank's
    std::size_t firstUnit_ = 0;          ///< of this rank's
    SortedParticles store_;
    std::vector<RangeTree> trees_;  ///< by range of this rank
    BuiltStep built_;
};

}  // namespace

Result<BuiltStep> buildStep(StepReader& reader, const std::array<Range, 3>& bounds,
                            const StepOptions& options, const StepResources& resources) {
    return Builder(reader, bounds, options, resources).run();
}

}  // namespace mote::prep
