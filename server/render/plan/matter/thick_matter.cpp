// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/matter/thick_matter.h"

#include <oneapi/tbb/combinable.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <span>

#include "server/render/plan/matter/leaves_by_cell.h"

namespace mote::render {
namespace {

// How far the matter in and around a cell spreads along all three axes (Spread): below the one it is too thin
// to be a volume, this much above it is one. Matter that is even everywhere has 2/9, a sheet close to 0.
constexpr double thinnest = 0.15, fromThinToThick = 0.03;
// The same of leaves as large as the volume's cells, in cells twice as large, in which what is thick enough
// for the volume may be thin: else what lies around a dense tilted core would be points in every other cell.
constexpr double thinnestAround = 0.13;
constexpr unsigned fewestLevels = 3;  // below, such a cell has hardly any around it
// What of the weight that is shown in and around a cell is as dense as what is seen: below the one a cell is
// alone, above the other it is part of a volume.
constexpr double loneliest = 0.6, companied = 0.9;
// The squared distance between the middle of what lies in a cell and the cell's centre, in cells: up to the
// one a cell is filled, from the other on it is the edge of something, which the volume would fill beyond its
// matter. A plane through the centre leaves 1/16, a plane at a quarter 9/64.
constexpr double centred = 0.05, lopsided = 0.1;
// The same of a cell and those around it: up to the one it lies within matter, from the other on at its rim.
constexpr double within = 0.02, atRim = 0.08;
// Within matter a leaf's points lie to one side by chance: by so much more is left to it there than it is on
// average.
constexpr double chanceWithin = 4.0;

double rise(double value, double from, double to) {
    return std::clamp((value - from) / (to - from), 0.0, 1.0);
}

/// How much a cell is filled to all sides, 0 to 1, by the middle of what lies in it and what of its squared
/// distance is chance.
double filled(const glm::dvec3& middle, double chance = 0.0) {
    return 1.0 - rise(glm::dot(middle, middle) - chance, centred, lopsided);
}

/// How the weights of 3 x 3 x 3 cells, each at its middle, are spread, in cells.
class Spread {
  public:
    /// From the centre of the one in the middle.
    glm::dvec3 middle() const { return weight_ > 0.0 ? first_ / weight_ : glm::dvec3(0.0); }
    void add(const glm::dvec3& place, double weight) {
        weight_ += weight;
        first_ += weight * place;
        square_ += weight * place * place;
        mixed_ += weight * glm::dvec3(place.y * place.z, place.z * place.x, place.x * place.y);
    }
    /// 1 / (1/a + 1/b + 1/c), of the variances along the principal axes: small where one of them is.
    double harmonic() const {
        if (!(weight_ > 0.0)) return 0.0;
        const glm::dvec3 mean = middle(), v = square_ / weight_ - mean * mean;
        const glm::dvec3 m = mixed_ / weight_ - glm::dvec3(mean.y * mean.z, mean.z * mean.x, mean.x * mean.y);
        const double determinant =
            v.x * v.y * v.z + 2.0 * m.x * m.y * m.z - v.x * m.x * m.x - v.y * m.y * m.y - v.z * m.z * m.z;
        const double minors = v.x * v.y + v.y * v.z + v.z * v.x - m.x * m.x - m.y * m.y - m.z * m.z;
        return minors > 0.0 ? std::max(determinant, 0.0) / minors : 0.0;
    }

  private:
    double weight_ = 0.0;
    glm::dvec3 first_{0.0}, square_{0.0}, mixed_{0.0};
};

/// How thick matter is told.
struct Look {
    double thinnest = render::thinnest;
    double densest = std::numeric_limits<double>::infinity();  ///< a leaf counts as this dense at most
    bool edges = false;  ///< a cell that is filled on one side is less of a volume
};

/// What a leaf is by the cells that it lies in, in 255ths.
struct LeafLook {
    std::uint8_t volume = 255;  ///< how much of it is part of a volume
    std::uint8_t rim = 0;       ///< how much it lies at the rim of matter
};

std::uint8_t in255ths(double share) {
    return static_cast<std::uint8_t>(std::lround(255.0 * share));
}

/// The leaves of a step as matter in the cells of one level.
class Matter {
  public:
    Matter(const storage::Leaves& leaves, const LeavesByCell& byCell, const ShownLeaves& shown,
           const CellGrid& grid, const Look& look)
        : look_(look),
          leaves_(leaves),
          byCell_(byCell),
          seen_(shown.seen),
          grid_(grid),
          sums_(grid.count()),
          dense_(grid.count()),
          beside_(grid.count()),
          middles_(grid.count()),
          shown_(grid.count()) {
        byCell_.forEach(grid.level, [&](std::size_t leaf, const CellAt& at) {
            add(leaf, at, leaves_.density[leaf] >= shown.thinnest, static_cast<double>(shown.points[leaf]));
        });
        for (std::size_t i = 0; i < sums_.size(); ++i)
            if (sums_[i] > 0.0) middles_[i] /= sums_[i];
    }

    /// Tells of the leaves whose cells these are, those of levels from `first` to `last`.
    void tell(unsigned first, unsigned last, std::vector<LeafLook>& looks) const {
        const auto cells = looksOfCells();
        byCell_.forEach(grid_.level, first, last, [&](std::size_t leaf, const CellAt& at) {
            if (seen_[leaf] == 0) return;
            grid_.forCells(at, [&](std::size_t cell, double) { looks[leaf] = cells[cell]; });
        });
    }

  private:
    void add(std::size_t leaf, const CellAt& at, bool dense, double points) {
        const double density = leaves_.density[leaf];
        const double counted = std::min(density, look_.densest);
        const glm::dvec3 place = grid_.placeInCell(at);
        grid_.forCells(at, [&](std::size_t cell, double part) {
            sums_[cell] += part * counted;
            if (dense) dense_[cell] += part * density;
            beside_[cell] += part * density * points;
            middles_[cell] += part * counted * place;
            shown_[cell] |= seen_[leaf];
        });
    }

    /// What a cell is, each 0 to 1.
    struct CellShare {
        double thickness = 0.0;  ///< matter spreads to all sides of it
        double company = 0.0;    ///< what is around it belongs to the volume, too
        double rim = 0.0;        ///< there is less on one side of it
    };

    /// Beyond the cells matter goes on as it is.
    CellShare shareOf(const glm::uvec3& cell) const {
        Spread spread;
        double dense = 0.0, beside = 0.0;
        for (int i = 0; i < 27; ++i) {
            const glm::ivec3 away(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
            const glm::ivec3 near =
                glm::clamp(glm::ivec3(cell) + away, glm::ivec3(grid_.low), glm::ivec3(grid_.high) - 1);
            const std::size_t at = grid_.index(glm::uvec3(near));
            spread.add(glm::dvec3(away) + middles_[at], sums_[at]);
            dense += dense_[at];
            beside += beside_[at];
        }
        return {rise(spread.harmonic(), look_.thinnest, look_.thinnest + fromThinToThick),
                rise(dense / (dense + beside), loneliest, companied),
                rise(glm::dot(spread.middle(), spread.middle()), within, atRim)};
    }

    /// Of each cell that is shown; it is part of a volume by the greatest thickness in and around it, times
    /// its company and, where it may be an edge, how much it is filled.
    std::vector<LeafLook> looksOfCells() const {
        std::vector<CellShare> found(sums_.size());
        grid_.forEach([&](const glm::uvec3& cell, std::size_t at) {
            if (shown_[at] != 0) found[at] = shareOf(cell);
        });
        std::vector<LeafLook> looks(found.size());
        grid_.forEach([&](const glm::uvec3& cell, std::size_t at) {
            if (shown_[at] == 0) return;
            double most = 0.0;
            grid_.forAround(cell, [&](std::size_t near) { most = std::max(most, found[near].thickness); });
            const double edge = look_.edges ? filled(middles_[at]) : 1.0;
            looks[at] = {in255ths(most * found[at].company * edge), in255ths(found[at].rim)};
        });
        return looks;
    }

    const Look look_;
    const storage::Leaves leaves_;
    const LeavesByCell& byCell_;
    const std::vector<std::uint8_t>& seen_;
    const CellGrid grid_;
    // By cell: the weight of all leaves, over the cell's share of the plot, of those that are as dense as any
    // that is seen, and of what is points of thinner ones; the middle of the first, in cells from the cell's
    // centre; whether any leaf is seen.
    std::vector<double> sums_, dense_, beside_;
    std::vector<glm::dvec3> middles_;
    std::vector<std::uint8_t> shown_;
};

// How many of a leaf's points are looked at, and of how few nothing can be told.
constexpr std::uint32_t mostPoints = 64, fewPoints = 4;
// Below the one share of the parts that even points would lie in, a leaf is lumps; above the other it is
// even.
constexpr double lumpiest = 0.5, evenest = 0.75;

/// How many of the 64 parts of a cell hold any of so many points, at most `mostPoints`, that lie anywhere.
double expectedParts(std::size_t points) {
    static const auto expected = [] {
        constexpr double parts = 64.0;
        std::array<double, mostPoints + 1> all{};
        for (std::size_t n = 0; n < all.size(); ++n)
            all[n] = parts * (1.0 - std::pow((parts - 1.0) / parts, static_cast<double>(n)));
        return all;
    }();
    return expected[points];
}

/// How evenly points lie in the cell of their leaf, 0 to 1: how many of its 4 x 4 x 4 parts hold any, of as
/// many as are expected to if they lie anywhere.
double evenness(std::span<const storage::PackedPosition> points) {
    if (points.size() < fewPoints) return 1.0;
    std::uint64_t held = 0;
    for (const auto& p : points)
        held |= std::uint64_t{1} << (unsigned{p.x} >> 14U | unsigned{p.y} >> 14U << 2U |
                                     unsigned{p.z} >> 14U << 4U);
    return std::clamp((std::popcount(held) / expectedParts(points.size()) - lumpiest) / (evenest - lumpiest),
                      0.0, 1.0);
}

/// How much the cell of a leaf is filled to all sides by its points, 0 to 1. `rim`: how much it lies at one.
double filled(std::span<const storage::PackedPosition> points, double rim) {
    if (points.size() < fewPoints) return 1.0;
    glm::dvec3 sum(0.0);
    for (const auto& p : points) sum += glm::dvec3(p.x, p.y, p.z);
    const auto count = static_cast<double>(points.size());
    const double chance = 0.25 / count;  // on average
    return filled((sum / count + 0.5) / 65536.0 - 0.5, chance * (chanceWithin + rim * (1.0 - chanceWithin)));
}

/// In 255ths, how much of a leaf lies in the volume: lumps do not, wherever they are, nor does the edge of
/// something.
std::vector<std::uint8_t> sharesOf(const storage::ParticleStep& step, const std::vector<std::uint8_t>& seen,
                                   const std::vector<LeafLook>& looks) {
    std::vector<std::uint8_t> shares(seen.size(), 255);
    const auto leaves = step.leaves();
    tbb::parallel_for(std::size_t{0}, leaves.size(), [&](std::size_t leaf) {
        if (seen[leaf] == 0) return;
        const auto [volume, rim] = looks[leaf];
        shares[leaf] = volume;
        if (volume == 0) return;
        const auto points =
            step.positions(leaves.pointBegin[leaf], std::min(leaves.pointCount[leaf], mostPoints));
        shares[leaf] =
            static_cast<std::uint8_t>(std::lround(volume * evenness(points) * filled(points, rim / 255.0)));
    });
    return shares;
}

using DensityByLevel = std::array<float, deepestLevel + 1>;

/// The densest leaf of each level that is seen; 0: none.
DensityByLevel densestSeen(const storage::Leaves& leaves, const LeavesByCell& byCell,
                           const std::vector<std::uint8_t>& seen) {
    tbb::combinable<DensityByLevel> found([] { return DensityByLevel{}; });
    byCell.forEach(deepestLevel, [&](std::size_t leaf, const CellAt& at) {
        if (seen[leaf] == 0) return;
        float& most = found.local()[at.level];
        most = std::max(most, leaves.density[leaf]);
    });
    return found.combine([](DensityByLevel one, const DensityByLevel& other) {
        for (std::size_t level = 0; level < one.size(); ++level)
            one[level] = std::max(one[level], other[level]);
        return one;
    });
}

}  // namespace

std::vector<std::uint8_t> thickMatter(const storage::ParticleStep& step, const ShownLeaves& shown,
                                      const CellGrid& grid, const glm::uvec3& low, const glm::uvec3& high) {
    const auto& seen = shown.seen;
    std::vector<LeafLook> looks(seen.size());
    const auto leaves = step.leaves();
    const LeavesByCell byCell(step);
    const auto densest = densestSeen(leaves, byCell, seen);
    unsigned coarsest = 0;
    while (coarsest <= grid.level && !(densest[coarsest] > 0.0F)) ++coarsest;
    const Look around{.thinnest = thinnestAround, .densest = densest[grid.level]};
    Matter(leaves, byCell, shown, grid, {.edges = true}).tell(grid.level + 1, deepestLevel, looks);
    // In cells of its own size a leaf is as thick as a cell, wherever its points lie: it is looked at in
    // larger ones.
    for (unsigned level = coarsest; level <= grid.level; ++level)
        Matter(leaves, byCell, shown, CellGrid::around(low, high, level - std::min(level, 1U)),
               level == grid.level && level >= fewestLevels ? around : Look())
            .tell(level, level, looks);
    return sharesOf(step, seen, looks);
}

}  // namespace mote::render
