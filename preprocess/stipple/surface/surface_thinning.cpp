// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/surface/surface_thinning.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "preprocess/stipple/surface/surface_job.h"

namespace mote::prep {
namespace {

/// Points by the area of their cells, the smallest first, of equals the one of the lower
/// number. Areas change as points move. A binary heap that knows where each point stands in it; one thread.
class RemovalQueue {
  public:
    /// Points 0 to areas.size(), square world units.
    explicit RemovalQueue(std::vector<float> areas) : areas_(std::move(areas)), places_(areas_.size()) {
        heap_.resize(areas_.size());
        for (std::uint32_t i = 0; i < heap_.size(); ++i) heap_[i] = places_[i] = i;
        for (auto i = static_cast<std::uint32_t>(heap_.size() / 2); i-- > 0;) sink(i);
    }

    bool empty() const { return heap_.empty(); }
    std::size_t size() const { return heap_.size(); }
    float area(std::uint32_t point) const { return areas_[point]; }

    /// Takes the smallest out.
    std::uint32_t take() {
        const auto point = heap_.front();
        const auto last = heap_.back();
        heap_.pop_back();
        if (!heap_.empty()) {
            put(0, last);
            sink(0);
        }
        places_[point] = out;
        return point;
    }
    /// Puts one back that was taken.
    void putBack(std::uint32_t point) {
        heap_.push_back(point);
        put(static_cast<std::uint32_t>(heap_.size() - 1), point);
        rise(places_[point]);
    }
    /// Changes the area of a point that is in it.
    void setArea(std::uint32_t point, float area) {
        areas_[point] = area;
        rise(places_[point]);
        sink(places_[point]);
    }

  private:
    static constexpr std::uint32_t out = UINT32_MAX;

    bool before(std::uint32_t a, std::uint32_t b) const {
        return areas_[a] != areas_[b] ? areas_[a] < areas_[b] : a < b;
    }
    void put(std::uint32_t place, std::uint32_t point) {
        heap_[place] = point;
        places_[point] = place;
    }
    void rise(std::uint32_t place) {
        const auto point = heap_[place];
        while (place > 0 && before(point, heap_[(place - 1) / 2])) {
            put(place, heap_[(place - 1) / 2]);
            place = (place - 1) / 2;
        }
        put(place, point);
    }
    void sink(std::uint32_t place) {
        const auto point = heap_[place];
        for (;;) {
            std::size_t child = 2 * static_cast<std::size_t>(place) + 1;
            if (child >= heap_.size()) break;
            if (child + 1 < heap_.size() && before(heap_[child + 1], heap_[child])) ++child;
            if (!before(heap_[child], point)) break;
            put(place, heap_[child]);
            place = static_cast<std::uint32_t>(child);
        }
        put(place, point);
    }

    std::vector<float> areas_;
    std::vector<std::uint32_t> heap_;    ///< points
    std::vector<std::uint32_t> places_;  ///< in heap_, by point
};

/// One in so many of the points that are left is tried at once: few enough that they seldom meet.
constexpr std::size_t together = 1000;
constexpr std::size_t mostTogether = 256;

/// What one removal would do.
struct Removal {
    struct Mover {
        std::uint32_t point;
        SurfacePoint to;
        glm::vec3 normal;
    };
    std::uint32_t point = 0;
    std::vector<Mover> movers;             ///< its rings, without those that stand still
    std::vector<std::uint32_t> concerned;  ///< whose cells change: the rings and what they touch
    bool accepted = false;
};

class Thinning {
  public:
    Thinning(const WalkMesh& mesh, PointSet set, const ThinningOptions& options)
        : mesh_(mesh),
          set_(std::move(set)),
          options_(options),
          cells_(mesh_, set_),
          left_(set_.points.size(), true),
          claimed_(set_.points.size(), 0),
          scratches_([this] {
              return Scratch{CellScratch(mesh_.triangles(), set_.points.size()), {}};
          }),
          queue_(begin()) {}

    Status run(double begin, Progress& progress) {
        const auto all = set_.points.size();
        while (!queue_.empty()) {
            if (progress.cancelled()) return wasCancelled();
            const double done = 1.0 - static_cast<double>(queue_.size()) / static_cast<double>(all);
            progress.report(begin + (1.0 - begin) * done, "thinning out");
            removeSome();
        }
        return success();
    }

    storage::StippleHierarchy take() && {
        storeMoves(moves_, hierarchy_);
        return std::move(hierarchy_);
    }

  private:
    struct Scratch {
        CellScratch cells;
        SurfaceCell cell;
    };

    /// The hierarchy before any removal; the areas of all cells.
    std::vector<float> begin() {
        const auto count = set_.points.size();
        std::vector<float> areas(count);
        hierarchy_.positions.reserve(count);
        for (const auto& point : set_.points) hierarchy_.positions.emplace_back(point.position);
        hierarchy_.normals = set_.normals;
        hierarchy_.removal.resize(count);
        hierarchy_.deathArea.resize(count);
        hierarchy_.locked.resize(count);
        tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(count), 256),
                          [&](const auto& range) {
                              for (auto i = range.begin(); i < range.end(); ++i) areas[i] = measure(i);
                          });
        return areas;
    }

    /// A point's area, noted as death area, and whether it is one that stands still. Different points on
    /// different threads.
    float measure(std::uint32_t point) {
        auto& scratch = scratches_.local();
        scratch.cells.supposeNothing();
        cells_.find(point, SurfaceCells::none, scratch.cells, scratch.cell);
        const auto area = static_cast<float>(scratch.cell.area);
        hierarchy_.deathArea[point] = std::max(hierarchy_.deathArea[point], area);
        if (!scratch.cell.flat) hierarchy_.locked[point] = 1;
        return area;
    }

    void removeSome() {
        const auto count = std::clamp<std::size_t>(queue_.size() / together, 1, mostTogether);
        if (2 * queue_.size() < filled_ || filled_ == 0) {
            filled_ = queue_.size();
            refill(set_, mesh_, left_, filled_);
        }
        set_.spacing = hexagonalSpacing(mesh_.area(), queue_.size());
        if (batch_.size() < count) batch_.resize(count);
        for (std::size_t i = 0; i < count; ++i) batch_[i].point = queue_.take();
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1), [&](const auto& range) {
            for (auto i = range.begin(); i < range.end(); ++i) plan(batch_[i]);
        });
        accept(count);
        measureConcerned(count);
    }

    /// What the removal would do, everything else where it is; each point from the cells that those before it
    /// left, over all of them twice.
    void plan(Removal& removal) {
        auto& [scratch, cell] = scratches_.local();
        removal.movers.clear();
        removal.concerned.clear();
        scratch.supposeNothing();
        cells_.find(removal.point, SurfaceCells::none, scratch, cell);
        auto& rings = removal.concerned;
        for (const auto neighbour : cell.neighbours) add(rings, neighbour, removal.point);
        std::size_t begin = 0;
        for (int ring = 0; ring < options_.rings; ++ring) {
            const auto end = rings.size();
            for (auto i = begin; i < end; ++i) {
                const auto mover = rings[i];
                cells_.find(mover, removal.point, scratch, cell);
                for (const auto neighbour : cell.neighbours) add(rings, neighbour, removal.point);
                if (!cell.flat) continue;
                removal.movers.push_back({mover, set_.points[mover], {}});
                move(removal.movers.back(), cell, scratch);
            }
            begin = end;
        }
        for (auto& mover : removal.movers) {
            cells_.find(mover.point, removal.point, scratch, cell);
            if (cell.flat) move(mover, cell, scratch);
        }
    }

    void move(Removal::Mover& mover, const SurfaceCell& cell, CellScratch& scratch) const {
        mover.to = mesh_.walk(mover.to, options_.relaxation * cell.toCentroid);
        mover.normal = glm::vec3(mesh_.normalAt(mover.to));
        scratch.suppose(mover.point, mover.to, mover.normal);
    }

    static void add(std::vector<std::uint32_t>& points, std::uint32_t point, std::uint32_t but) {
        if (point != but && std::find(points.begin(), points.end(), point) == points.end()) {
            points.push_back(point);
        }
    }

    /// Accepts in the order of their areas those that concern no point of an earlier one. The others wait.
    void accept(std::size_t count) {
        ++round_;
        for (std::size_t i = 0; i < count; ++i) {
            auto& removal = batch_[i];
            const auto taken = [&](std::uint32_t point) { return claimed_[point] == round_; };
            removal.accepted = !taken(removal.point) &&
                               std::none_of(removal.concerned.begin(), removal.concerned.end(), taken);
            if (!removal.accepted) continue;
            claimed_[removal.point] = round_;
            for (const auto point : removal.concerned) claimed_[point] = round_;
            apply(removal);
        }
        for (std::size_t i = 0; i < count; ++i) {
            if (!batch_[i].accepted) queue_.putBack(batch_[i].point);
        }
    }

    void apply(const Removal& removal) {
        hierarchy_.removal[removal.point] = removal_++;
        left_[removal.point] = false;
        set_.grid.remove(removal.point, set_.points[removal.point].position);
        for (const auto& [mover, to, normal] : removal.movers) {
            set_.grid.move(mover, set_.points[mover].position, to.position);
            set_.points[mover] = to;
            set_.normals[mover] = normal;
            moves_.push_back({mover, removal.point, glm::vec3(to.position)});
        }
    }

    void measureConcerned(std::size_t count) {
        changed_.clear();
        for (std::size_t i = 0; i < count; ++i) {
            const auto& removal = batch_[i];
            if (!removal.accepted) continue;
            changed_.insert(changed_.end(), removal.concerned.begin(), removal.concerned.end());
        }
        areas_.resize(changed_.size());
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, changed_.size(), 16), [&](const auto& range) {
            for (auto i = range.begin(); i < range.end(); ++i) areas_[i] = measure(changed_[i]);
        });
        for (std::size_t i = 0; i < changed_.size(); ++i) queue_.setArea(changed_[i], areas_[i]);
    }

    const WalkMesh& mesh_;
    PointSet set_;
    ThinningOptions options_;
    SurfaceCells cells_;
    storage::StippleHierarchy hierarchy_;
    std::vector<bool> left_;
    std::vector<std::uint32_t> claimed_;  ///< by point, the round in which a removal concerned it
    std::uint32_t round_ = 0;
    std::uint32_t removal_ = 0;
    std::size_t filled_ = 0;  ///< points in the grid when it was made
    tbb::enumerable_thread_specific<Scratch> scratches_;
    RemovalQueue queue_;
    std::vector<Removal> batch_;
    std::vector<std::uint32_t> changed_;
    std::vector<float> areas_;
    RecordedMoves moves_;
};

}  // namespace

Result<storage::StippleHierarchy> thinSurface(const WalkMesh& mesh, PointSet set,
                                              const ThinningOptions& options, double begin,
                                              Progress& progress) {
    Thinning thinning(mesh, std::move(set), options);
    MOTE_RETURN_IF_ERROR(thinning.run(begin, progress));
    return std::move(thinning).take();
}

}  // namespace mote::prep
