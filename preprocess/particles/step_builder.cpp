// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/step_builder.h"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>

#include "preprocess/job.h"
#include "preprocess/particles/cell_plan.h"
#include "preprocess/particles/particle_exchange.h"
#include "preprocess/particles/range_builder.h"

namespace mote::prep {
namespace {

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
        MOTE_RETURN_IF_ERROR(shareTrees());
        MOTE_ASSIGN_OR_RETURN(built_.octree, assembleOctree(std::move(plan_.levels)));
        built_.points = std::move(store_.particles);
        return std::move(built_);
    }

  private:
    std::size_t rank() const { return static_cast<std::size_t>(ranks_.rank()); }

    Status plan() {
        auto mine = countCells(reader_, bounds_, gridLevel_);
        MOTE_RETURN_IF_ERROR(agree(ranks_, mine.ok() ? success() : Status(mine.error())));
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
            return spill ? RecordStore::inFile(resources_.temporary, size) : RecordStore::inMemory(size);
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
                worker.status = resources_.cancelled() ? cancelledError() : buildRange(i, worker);
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

    /// Puts what all ranks found below the grid into the plan's levels.
    Status shareTrees() {
        std::vector<UnitTree> units;
        OctreeLevels mine(options_.octree.maxLevel > gridLevel_ ? options_.octree.maxLevel - gridLevel_ : 0);
        for (auto& tree : trees_) {
            appendTo(units, tree.units);
            for (std::size_t depth = 0; depth < mine.size(); ++depth) {
                appendTo(mine[depth].children, tree.levels[depth].children);
                appendTo(mine[depth].count, tree.levels[depth].count);
                appendTo(mine[depth].weight, tree.levels[depth].weight);
            }
            tree = {};
        }
        trees_.clear();
        MOTE_RETURN_IF_ERROR(shareUnits(units));
        for (auto& level : mine) {
            auto& whole = plan_.levels.emplace_back();
            MOTE_RETURN_IF_ERROR(shareInto(whole.children, level.children));
            MOTE_RETURN_IF_ERROR(shareInto(whole.count, level.count));
            MOTE_RETURN_IF_ERROR(shareInto(whole.weight, level.weight));
        }
        return success();
    }

    Status shareUnits(std::vector<UnitTree>& mine) {
        std::vector<UnitTree> all;
        MOTE_RETURN_IF_ERROR(shareInto(all, mine));
        for (std::size_t i = 0; i < all.size(); ++i) {
            const auto& unit = plan_.units[i];
            plan_.levels[unit.level].weight[unit.index] = all[i].weight;
            if (unit.divided) plan_.levels[unit.level].children[unit.index] = all[i].children;
        }
        return success();
    }

    /// All ranks' values in turn; this one's are given up.
    template <class T>
    Status shareInto(std::vector<T>& all, std::vector<T>& mine) {
        if (ranks_.size() == 1) {
            all = std::move(mine);
            return success();
        }
        MOTE_ASSIGN_OR_RETURN(const auto shared, shareValues<T>(ranks_, mine));
        mine = std::vector<T>();
        for (const auto& values : shared) appendTo(all, values);
        return success();
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
