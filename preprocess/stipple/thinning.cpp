// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/stipple/thinning.h"

#include <algorithm>
#include <numeric>

#include "preprocess/stipple/periodic_triangulation.h"

namespace mote::prep {
namespace {

/// Sweeps over the moving points at a removal: one leaves second moments 1 % above those of two, three gain
/// little.
constexpr int sweeps = 2;

glm::vec3 onPlane(glm::dvec2 position) {
    return {static_cast<float>(position.x), static_cast<float>(position.y), 0.0F};
}

/// A set of points that is emptied in no time.
class PointSet {
  public:
    explicit PointSet(std::size_t size) : turn_(size) {}
    void clear() {
        points_.clear();
        ++now_;
    }
    void add(std::uint32_t point) {
        if (std::exchange(turn_[point], now_) != now_) points_.push_back(point);
    }
    /// Marks it as one that is there, without listing it.
    void hide(std::uint32_t point) { turn_[point] = now_; }
    const std::vector<std::uint32_t>& points() const { return points_; }

  private:
    std::vector<std::uint32_t> turn_;
    std::uint32_t now_ = 0;
    std::vector<std::uint32_t> points_;
};

class Thinning {
  public:
    Thinning(const std::vector<glm::dvec2>& points, const ThinningOptions& options)
        : options_(options),
          triangulation_(points),
          queue_(startAreas(points.size())),
          movers_(points.size()),
          changed_(points.size()) {
        for (std::uint32_t i = 0; i < points.size(); ++i) {
            hierarchy_.positions.push_back(onPlane(triangulation_.position(i)));
            hierarchy_.deathArea.push_back(static_cast<float>(queue_.area(i)));
        }
        hierarchy_.normals.assign(points.size(), {0.0F, 0.0F, 1.0F});
        hierarchy_.removal.resize(points.size());
        hierarchy_.locked.assign(points.size(), 0);
    }

    Status run(double begin, Progress& progress) {
        const auto all = static_cast<std::uint32_t>(hierarchy_.size());
        for (std::uint32_t removal = 0; removal < all; ++removal) {
            if (removal % 256 == 0) {
                if (progress.cancelled()) return wasCancelled();
                progress.report(begin + (1.0 - begin) * removal / all, "thinning out");
            }
            const auto point = queue_.smallest();
            hierarchy_.removal[point] = removal;
            queue_.removeSmallest();
            if (!queue_.empty()) remove(point);
        }
        return success();
    }

    storage::StippleHierarchy take() && {
        storeMoves(moves_, hierarchy_);
        return std::move(hierarchy_);
    }

  private:
    PlaneCell cell(std::uint32_t point) {
        for (;;) {
            if (const auto cell = triangulation_.cell(point)) return *cell;
            triangulation_.widen();
        }
    }

    std::vector<double> startAreas(std::size_t points) {
        std::vector<double> areas;
        for (std::uint32_t i = 0; i < points; ++i) areas.push_back(cell(i).area);
        return areas;
    }

    void remove(std::uint32_t point) {
        findMovers(point);
        triangulation_.remove(point);
        moveAll(point);
        changed_.clear();
        for (const auto mover : movers_.points()) {
            changed_.add(mover);
            addNeighbours(mover, changed_);
        }
        for (const auto changed : changed_.points()) {
            const double area = cell(changed).area;
            queue_.update(changed, area);
            hierarchy_.deathArea[changed] = std::max(hierarchy_.deathArea[changed], static_cast<float>(area));
        }
    }

    /// The point's neighbours in as many rings as move.
    void findMovers(std::uint32_t point) {
        movers_.clear();
        movers_.hide(point);
        addNeighbours(point, movers_);
        if (options_.rings < 2) return;
        const auto first = movers_.points();
        for (const auto neighbour : first) addNeighbours(neighbour, movers_);
    }

    void addNeighbours(std::uint32_t point, PointSet& set) {
        neighbours_.clear();
        triangulation_.addNeighbours(point, neighbours_);
        for (const auto neighbour : neighbours_) set.add(neighbour);
    }

    /// Lloyd's method, from the hole outwards; each point sees where those before it went.
    void moveAll(std::uint32_t removed) {
        if (options_.rings == 0) return;
        for (int sweep = 0; sweep < sweeps; ++sweep) {
            for (const auto mover : movers_.points()) {
                triangulation_.move(mover, options_.relaxation * cell(mover).centroid);
            }
        }
        for (const auto mover : movers_.points()) {
            moves_.push_back({mover, removed, onPlane(triangulation_.position(mover))});
        }
    }

    ThinningOptions options_;
    PeriodicTriangulation triangulation_;
    AreaQueue queue_;
    storage::StippleHierarchy hierarchy_;
    RecordedMoves moves_;
    PointSet movers_;
    PointSet changed_;
    std::vector<std::uint32_t> neighbours_;
};

}  // namespace

AreaQueue::AreaQueue(std::vector<double> areas)
    : areas_(std::move(areas)), heap_(areas_.size()), slot_(areas_.size()) {
    std::iota(heap_.begin(), heap_.end(), 0U);
    std::iota(slot_.begin(), slot_.end(), 0U);
    for (std::size_t slot = heap_.size() / 2; slot-- > 0;) sink(slot);
}

void AreaQueue::removeSmallest() {
    const auto last = heap_.back();
    heap_.pop_back();
    if (heap_.empty()) return;
    put(0, last);
    sink(0);
}

void AreaQueue::update(std::uint32_t point, double area) {
    const bool smaller = area < areas_[point];
    areas_[point] = area;
    if (smaller) {
        rise(slot_[point]);
    } else {
        sink(slot_[point]);
    }
}

void AreaQueue::rise(std::size_t slot) {
    const auto point = heap_[slot];
    while (slot > 0 && before(point, heap_[(slot - 1) / 2])) {
        put(slot, heap_[(slot - 1) / 2]);
        slot = (slot - 1) / 2;
    }
    put(slot, point);
}

void AreaQueue::sink(std::size_t slot) {
    const auto point = heap_[slot];
    for (std::size_t child = 2 * slot + 1; child < heap_.size(); child = 2 * slot + 1) {
        if (child + 1 < heap_.size() && before(heap_[child + 1], heap_[child])) ++child;
        if (!before(heap_[child], point)) break;
        put(slot, heap_[child]);
        slot = child;
    }
    put(slot, point);
}

Result<storage::StippleHierarchy> thinPlane(const std::vector<glm::dvec2>& points,
                                            const ThinningOptions& options, double begin,
                                            Progress& progress) {
    Thinning thinning(points, options);
    MOTE_RETURN_IF_ERROR(thinning.run(begin, progress));
    return std::move(thinning).take();
}

void storeMoves(const RecordedMoves& moves, storage::StippleHierarchy& hierarchy) {
    auto& h = hierarchy;
    h.movesBegin.assign(h.size() + 1, 0);
    for (const auto& move : moves) ++h.movesBegin[move.point + 1];
    for (std::size_t i = 0; i < h.size(); ++i) h.movesBegin[i + 1] += h.movesBegin[i];
    auto next = h.movesBegin;
    h.moveNeighbour.resize(moves.size());
    h.movePosition.resize(moves.size());
    for (const auto& move : moves) {
        const auto at = next[move.point]++;
        h.moveNeighbour[at] = move.neighbour;
        h.movePosition[at] = move.position;
    }
}

}  // namespace mote::prep
