// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reference/volume_field.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace mote::reference {
namespace {

/// Every third bit of a Morton code.
std::int64_t placeAlong(std::uint64_t morton, unsigned axis) {
    std::int64_t place = 0;
    for (unsigned bit = 0; bit < 21; ++bit)
        place |= static_cast<std::int64_t>(morton >> (3 * bit + axis) & 1) << bit;
    return place;
}

/// A place of a level, at another one: of a coarser, the cell that holds it; of a finer, its first.
std::int64_t atLevel(std::int64_t place, int from, int to) {
    return to >= from ? place * (std::int64_t{1} << (to - from)) : place / (std::int64_t{1} << (from - to));
}

/// docs/PICTURE.md, "Colour by a column": the mean of a leaf's values; NaN where it has none.
double meanValue(const render::PointValues& values, std::uint64_t first, std::uint64_t count) {
    double sum = 0.0, having = 0.0;
    for (std::uint64_t point = first; point < first + count; ++point) {
        const auto code = values.codes.at(point);
        if (code == render::noValue) continue;
        sum += static_cast<double>(code) / render::greatestValue;
        having += 1.0;
    }
    return sum / having;
}

/// docs/PICTURE.md, "Share": how evenly the first points of a leaf lie in its cell.
double evennessOf(const storage::ParticleStep& step, std::uint64_t first, std::uint64_t count) {
    const auto n = std::min<std::uint64_t>(count, 64);
    if (n < 4) return 1.0;
    std::set<std::array<int, 3>> parts;
    for (const auto& p : step.positions(first, n)) parts.insert({p.x / 16384, p.y / 16384, p.z / 16384});
    const double expected = 64.0 * (1.0 - std::pow(63.0 / 64.0, static_cast<double>(n)));
    return std::clamp((static_cast<double>(parts.size()) / expected - 0.5) / 0.25, 0.0, 1.0);
}

/// docs/PICTURE.md, "Share": how much a cell is filled to all sides if what is in it has such a middle.
double filledBy(double distance) {
    return 1.0 - std::clamp((distance - 0.05) / 0.05, 0.0, 1.0);
}

/// Of a leaf's first points: how far from the centre of its cell their middle lies, squared, in cells.
double middleOf(const storage::ParticleStep& step, std::uint64_t first, std::uint64_t count) {
    const auto n = std::min<std::uint64_t>(count, 64);
    std::array<double, 3> off{};
    for (const auto& p : step.positions(first, n)) {
        const std::array<double, 3> at{p.x + 0.5, p.y + 0.5, p.z + 0.5};
        for (std::size_t axis = 0; axis < 3; ++axis)
            off[axis] += (at[axis] / 65536.0 - 0.5) / static_cast<double>(n);
    }
    return off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
}

}  // namespace

VolumeField::VolumeField(const storage::ParticleStep& step, const ParticlesStyle& style,
                         const render::PointValues* values, const ColorMap* map)
    : transfer_(style.transfer()) {
    if (map != nullptr) {
        transfer_.colorMap = *map;
        transfer_.colorRange = {0.0, 1.0};
    }
    const auto all = leavesOf(step, style.pointFraction, values);
    std::vector<Leaf> leaves;
    std::copy_if(all.begin(), all.end(), std::back_inserter(leaves),
                 [](const Leaf& leaf) { return leaf.extinction > 0.0; });
    if (leaves.empty()) return;
    int finest = 0;
    for (const auto& leaf : leaves) finest = std::max(finest, leaf.level);
    const double most = std::min(std::pow(step.volumeSize(), 3.0), 2097152.0);
    int level = std::min(finest, 12);
    while (level > 0 && !choose(leaves, level, most)) --level;
    if (level == 0) choose(leaves, 0, most);
    shares_.assign(step.leaves().size(), 1.0);
    fill(leaves, all);
}

std::vector<VolumeField::Leaf> VolumeField::leavesOf(const storage::ParticleStep& step, const Curve& fraction,
                                                     const render::PointValues* values) const {
    const auto nodes = step.nodes();
    const auto leaves = step.leaves();
    const LogDensity scale = step.logDensity();
    std::vector<Leaf> found;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const double density = leaves.density[i], t = scale.ofLeaf(density);
        const double extinction = density > 0.0 ? transfer_.extinction(t) : 0.0;
        const auto morton = nodes.morton[leaves.node[i]];
        found.push_back(
            {i,
             nodes.level[leaves.node[i]],
             {placeAlong(morton, 0), placeAlong(morton, 1), placeAlong(morton, 2)},
             density,
             values == nullptr ? t : meanValue(*values, leaves.pointBegin[i], leaves.pointCount[i]),
             extinction,
             fraction(t),
             evennessOf(step, leaves.pointBegin[i], leaves.pointCount[i]),
             middleOf(step, leaves.pointBegin[i], leaves.pointCount[i]),
             std::min<std::uint64_t>(leaves.pointCount[i], 64)});
    }
    return found;
}

/// Where the weight of all leaves lies in the cells of one level, how thick those are that hold what is seen,
/// and what company they have.
class VolumeField::ThickCells {
  public:
    using Place = std::array<std::int64_t, 3>;

    /// `thin`: how much is not thick at all; `densest`: what leaves count as at most.
    ThickCells(const std::vector<Leaf>& leaves, const std::vector<Leaf>& all, int level, double thin,
               double densest)
        : level_(level), thin_(thin), densest_(densest) {
        // The cells around what is seen, one more on each side, within the plot.
        const std::int64_t side = std::int64_t{1} << level;
        low_.fill(side);
        for (const auto& leaf : leaves) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const std::int64_t from = atLevel(leaf.place[axis], leaf.level, level);
                low_[axis] = std::min(low_[axis], std::max<std::int64_t>(from - 1, 0));
                last_[axis] = std::max(last_[axis], std::min(from + width(leaf), side - 1));
            }
        }
        std::size_t count = 1;
        for (std::size_t axis = 0; axis < 3; ++axis)
            count *= static_cast<std::size_t>(last_[axis] - low_[axis] + 1);
        weights_.resize(count);
        double least = std::numeric_limits<double>::infinity();
        for (const auto& leaf : leaves) least = std::min(least, leaf.density);
        for (const auto& leaf : all) add(leaf, least);
        std::vector<bool> seen(count, false);
        for (const auto& leaf : leaves)
            forCells(leaf, [&](const Place& cell, double) { seen[index(cell)] = true; });
        thick_.assign(count, 0.0);
        forBox(low_, last_, [&](const Place& cell) {
            if (seen[index(cell)]) thick_[index(cell)] = thickness(cell);
        });
    }

    /// The greatest thickness in and around a cell, times the cell's company.
    double share(const Place& cell) const {
        Place from{}, to{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            from[axis] = std::max(cell[axis] - 1, low_[axis]);
            to[axis] = std::min(cell[axis] + 1, last_[axis]);
        }
        double most = 0.0;
        forBox(from, to, [&](const Place& near) { most = std::max(most, thick_[index(near)]); });
        return most * company(cell);
    }

    /// How much a cell is filled to all sides.
    double filled(const Place& cell) const {
        const Weight& weight = weights_[index(cell)];
        const glm::dvec3 middle = weight.moment / weight.sum;
        return filledBy(glm::dot(middle, middle));
    }

    /// How much a leaf of that cell is filled to all sides by its points.
    double filled(const Place& cell, const Leaf& leaf) const {
        if (leaf.pointsSeen < 4) return 1.0;
        const double chance = 1.0 / (4.0 * static_cast<double>(leaf.pointsSeen));
        return filledBy(leaf.middle - (4.0 - 3.0 * rim(cell)) * chance);
    }

  private:
    /// How much a cell lies at the rim of matter, in 255ths.
    double rim(const Place& cell) const {
        double sum = 0.0;
        glm::dvec3 moment(0.0);
        forNear(cell, [&](const Weight& weight, const glm::dvec3& away) {
            sum += weight.sum;
            moment += weight.moment + weight.sum * away;
        });
        const glm::dvec3 middle = moment / sum;
        return std::round(255.0 * std::clamp((glm::dot(middle, middle) - 0.02) / 0.06, 0.0, 1.0)) / 255.0;
    }

    struct Weight {
        /// Of all, of what is as dense as any that is seen, and of what is points of thinner leaves.
        double sum = 0.0, dense = 0.0, beside = 0.0;
        glm::dvec3 moment{0.0};
    };

    /// Of a leaf, in cells.
    std::int64_t width(const Leaf& leaf) const {
        return leaf.level < level_ ? std::int64_t{1} << (level_ - leaf.level) : 1;
    }

    /// Those of its cells that lie around what is seen.
    template <class Visit>
    void forCells(const Leaf& leaf, const Visit& visit) const {
        const double part = std::ldexp(1.0, -3 * std::max(leaf.level - level_, 0));
        Place from{}, to{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t first = atLevel(leaf.place[axis], leaf.level, level_);
            from[axis] = std::max(first, low_[axis]);
            to[axis] = std::min(first + width(leaf) - 1, last_[axis]);
        }
        forBox(from, to, [&](const Place& cell) { visit(cell, part); });
    }

    template <class Visit>
    static void forBox(const Place& from, const Place& to, const Visit& visit) {
        for (std::int64_t z = from[2]; z <= to[2]; ++z) {
            for (std::int64_t y = from[1]; y <= to[1]; ++y) {
                for (std::int64_t x = from[0]; x <= to[0]; ++x) visit(Place{x, y, z});
            }
        }
    }

    std::size_t index(const Place& cell) const {
        const std::int64_t wide = last_[0] - low_[0] + 1, high = last_[1] - low_[1] + 1;
        return static_cast<std::size_t>(((cell[2] - low_[2]) * high + cell[1] - low_[1]) * wide + cell[0] -
                                        low_[0]);
    }

    void add(const Leaf& leaf, double leastSeen) {
        glm::dvec3 at(0.0);
        for (std::size_t axis = 0; axis < 3 && leaf.level > level_; ++axis) {
            const double place =
                (static_cast<double>(leaf.place[axis]) + 0.5) * std::ldexp(1.0, level_ - leaf.level);
            at[static_cast<int>(axis)] = place - std::floor(place) - 0.5;
        }
        forCells(leaf, [&](const Place& cell, double part) {
            auto& weight = weights_[index(cell)];
            weight.sum += part * std::min(leaf.density, densest_);
            if (leaf.density >= leastSeen) weight.dense += part * leaf.density;
            if (leaf.density < leastSeen) weight.beside += part * leaf.density * leaf.points;
            weight.moment += part * std::min(leaf.density, densest_) * at;
        });
    }

    /// Calls visit(what lies there, which of the 27 cells it is) for a cell and those around it; beyond the
    /// cells matter goes on as it is.
    template <class Visit>
    void forNear(const Place& cell, const Visit& visit) const {
        for (int i = 0; i < 27; ++i) {
            const std::array<int, 3> away{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
            Place near{};
            for (std::size_t axis = 0; axis < 3; ++axis)
                near[axis] = std::clamp(cell[axis] + away[axis], low_[axis], last_[axis]);
            visit(weights_[index(near)], glm::dvec3(away[0], away[1], away[2]));
        }
    }

    /// How much of what is shown of the weight of the 27 cells in and around one is dense.
    double company(const Place& cell) const {
        double dense = 0.0, beside = 0.0;
        forNear(cell, [&](const Weight& weight, const glm::dvec3&) {
            dense += weight.dense;
            beside += weight.beside;
        });
        return std::clamp((dense / (dense + beside) - 0.6) / 0.3, 0.0, 1.0);
    }

    /// Of the weight of these cells: the harmonic mean of the variances along its principal axes, over 3.
    double thickness(const Place& cell) const {
        glm::dmat3 second(0.0);
        glm::dvec3 first(0.0);
        double sum = 0.0;
        forNear(cell, [&](const Weight& weight, const glm::dvec3& away) {
            if (!(weight.sum > 0.0)) return;
            const glm::dvec3 where = away + weight.moment / weight.sum;
            sum += weight.sum;
            first += weight.sum * where;
            second += weight.sum * glm::outerProduct(where, where);
        });
        const glm::dmat3 spread = second / sum - glm::outerProduct(first / sum, first / sum);
        // The sum of the inverse's diagonal is that of the inverse variances.
        if (!(glm::determinant(spread) > 0.0)) return 0.0;
        const glm::dmat3 inverse = glm::inverse(spread);
        const double harmonic = 1.0 / (inverse[0][0] + inverse[1][1] + inverse[2][2]);
        return std::clamp((harmonic - thin_) / 0.03, 0.0, 1.0);
    }

    int level_;
    double thin_, densest_;
    Place low_{}, last_{};
    std::vector<Weight> weights_;
    std::vector<double> thick_;
};

/// The cells of a level around all leaves, and one more on each side; false where there are more than `most`.
bool VolumeField::choose(const std::vector<Leaf>& leaves, int level, double most) {
    double count = 1.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t side = std::int64_t{1} << level;
        std::int64_t low = side, high = 0;
        for (const auto& leaf : leaves) {
            low = std::min(low, atLevel(leaf.place[axis], leaf.level, level));
            const std::int64_t next = leaf.place[axis] + 1;
            const std::int64_t last = level >= leaf.level ? atLevel(next, leaf.level, level)
                                                          : atLevel(leaf.place[axis], leaf.level, level) + 1;
            high = std::max(high, last);
        }
        first_[axis] = std::max<std::int64_t>(low - 1, 0);
        size_[axis] = std::min(high + 1, side) - first_[axis];
        count *= static_cast<double>(size_[axis]);
    }
    level_ = level;
    edge_ = std::ldexp(2.0, -level);
    return count <= most;
}

std::size_t VolumeField::index(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return static_cast<std::size_t>(((z - first_[2]) * size_[1] + (y - first_[1])) * size_[0] +
                                    (x - first_[0]));
}

void VolumeField::fill(const std::vector<Leaf>& leaves, const std::vector<Leaf>& all) {
    const auto count = static_cast<std::size_t>(size_[0] * size_[1] * size_[2]);
    std::vector<double> matter(count, 0.0), colored(count, 0.0), moment(count, 0.0);
    const auto forCells = [&](const Leaf& leaf, const std::function<void(std::size_t, double)>& visit) {
        const double part = leaf.level > level_ ? std::ldexp(1.0, -3 * (leaf.level - level_)) : 1.0;
        const std::int64_t side = leaf.level < level_ ? std::int64_t{1} << (level_ - leaf.level) : 1;
        std::array<std::int64_t, 3> low{}, high{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t from = atLevel(leaf.place[axis], leaf.level, level_);
            low[axis] = std::max(from, first_[axis]);
            high[axis] = std::min(from + side, first_[axis] + size_[axis]);
        }
        for (std::int64_t z = low[2]; z < high[2]; ++z) {
            for (std::int64_t y = low[1]; y < high[1]; ++y) {
                for (std::int64_t x = low[0]; x < high[0]; ++x) visit(index(x, y, z), part);
            }
        }
    };
    for (const auto& leaf : leaves) {
        forCells(leaf, [&](std::size_t cell, double part) {
            matter[cell] += part * leaf.extinction;
            if (std::isnan(leaf.t)) return;
            colored[cell] += part * leaf.extinction;
            moment[cell] += part * leaf.extinction * leaf.t;
        });
    }
    const auto around = [&](std::size_t cell, const std::function<void(std::size_t)>& visit) {
        const auto at = static_cast<std::int64_t>(cell);
        const std::int64_t x = at % size_[0], y = at / size_[0] % size_[1], z = at / (size_[0] * size_[1]);
        for (std::int64_t k = std::max<std::int64_t>(z - 1, 0); k <= std::min(z + 1, size_[2] - 1); ++k) {
            for (std::int64_t j = std::max<std::int64_t>(y - 1, 0); j <= std::min(y + 1, size_[1] - 1); ++j) {
                for (std::int64_t i = std::max<std::int64_t>(x - 1, 0); i <= std::min(x + 1, size_[0] - 1);
                     ++i)
                    visit(static_cast<std::size_t>((k * size_[1] + j) * size_[0] + i));
            }
        }
    };
    findShares(leaves, all);
    std::vector<double> extinction(count, 0.0);
    t_.assign(count, 0.0);
    for (const auto& leaf : leaves) {
        forCells(leaf, [&](std::size_t cell, double part) {
            extinction[cell] += part * shares_[leaf.number] * leaf.extinction;
        });
    }
    root_ = rootsOf(extinction);
    held_.assign(count, 0.0);
    for (std::size_t cell = 0; cell < count; ++cell) {
        double sum = 0.0, moments = 0.0, whole = 0.0, held = 0.0;
        around(cell, [&](std::size_t near) {
            whole += matter[near];
            held += extinction[near];
            sum += colored[near];
            moments += moment[near];
        });
        if (colored[cell] > 0.0)
            t_[cell] = moment[cell] / colored[cell];
        else if (sum > 0.0)
            t_[cell] = moments / sum;
        if (whole > 0.0) held_[cell] = held / whole;
    }
}

/// docs/PICTURE.md, "Volume": the mean square around a cell is a sum over pairs of the 27 cells in and around
/// it.
std::vector<double> VolumeField::rootsOf(const std::vector<double>& extinction) const {
    std::vector<double> cubeRoots(extinction.size());
    std::transform(extinction.begin(), extinction.end(), cubeRoots.begin(),
                   [](double one) { return std::cbrt(one); });
    // Along an axis: the integral of a cell's tent times those of two cells that lie so far from it.
    const auto common = [](std::int64_t one, std::int64_t other) {
        if (one == 0 && other == 0) return 0.5;
        return one == -other ? 0.0 : 1.0 / 12.0;
    };
    const auto away = [](std::int64_t cell) {
        return std::array<std::int64_t, 3>{cell % 3 - 1, cell / 3 % 3 - 1, cell / 9 - 1};
    };
    auto roots = cubeRoots;
    for (std::int64_t cell = 0; cell < static_cast<std::int64_t>(roots.size()); ++cell) {
        double& root = roots[static_cast<std::size_t>(cell)];
        if (!(root > 0.0)) continue;
        const std::array<std::int64_t, 3> place{cell % size_[0], cell / size_[0] % size_[1],
                                                cell / (size_[0] * size_[1])};
        std::vector<double> near;
        for (std::int64_t i = 0; i < 27; ++i) {
            auto at = away(i);
            for (std::size_t axis = 0; axis < 3; ++axis)
                at[axis] = std::clamp<std::int64_t>(place[axis] + at[axis], 0, size_[axis] - 1);
            near.push_back(cubeRoots[index(first_[0] + at[0], first_[1] + at[1], first_[2] + at[2])]);
        }
        double squares = 0.0;
        for (std::int64_t i = 0; i < 27; ++i) {
            for (std::int64_t j = 0; j < 27; ++j) {
                double integral = 1.0;
                for (std::size_t axis = 0; axis < 3; ++axis) integral *= common(away(i)[axis], away(j)[axis]);
                squares += near[static_cast<std::size_t>(i)] * near[static_cast<std::size_t>(j)] * integral;
            }
        }
        root *= std::cbrt(root * root / squares);
    }
    return roots;
}

/// The cell of a level, at most the leaf's, that a leaf lies in.
std::array<std::int64_t, 3> VolumeField::cellOf(const Leaf& leaf, int level) {
    std::array<std::int64_t, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis) cell[axis] = atLevel(leaf.place[axis], leaf.level, level);
    return cell;
}

/// docs/PICTURE.md, "Share": a leaf's cells are of the volume's level, or of the one above its own where that
/// is coarser.
void VolumeField::findShares(const std::vector<Leaf>& leaves, const std::vector<Leaf>& all) {
    // Of leaves as large as cells, what is denser counts as the densest of them.
    double densest = 0.0;
    for (const auto& leaf : leaves)
        if (leaf.level == level_) densest = std::max(densest, leaf.density);
    std::map<std::pair<int, bool>, ThickCells> looks;
    for (const auto& leaf : leaves) {
        const int level = std::min(level_, std::max(leaf.level - 1, 0));
        const std::pair look{level, leaf.level == level_ && level_ > 2};
        auto found = looks.find(look);
        if (found == looks.end()) {
            const double most = look.second ? densest : std::numeric_limits<double>::infinity();
            found =
                looks.emplace(look, ThickCells(leaves, all, level, look.second ? 0.13 : 0.15, most)).first;
        }
        const bool small = leaf.level > level_;
        const auto cell = cellOf(leaf, level);
        const double share = found->second.share(cell) * (small ? found->second.filled(cell) : 1.0);
        const double points = std::round(255.0 * share) * leaf.evenness * found->second.filled(cell, leaf);
        shares_[leaf.number] = std::isnan(leaf.t) ? 0.0 : std::round(points) / 255.0;
    }
}

double VolumeField::between(const std::vector<double>& cells, const glm::dvec3& inLayer) const {
    if (cells.empty()) return 0.0;
    std::array<std::size_t, 3> below{}, above{};
    std::array<double, 3> share{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        // Cell i has its centre at i + 1/2 cells from the box's side.
        const auto last = static_cast<double>(size_[axis] - 1);
        const double inCells =
            (inLayer[static_cast<int>(axis)] + 1.0) / edge_ - static_cast<double>(first_[axis]);
        const double place = std::clamp(inCells - 0.5, 0.0, last);
        below[axis] = static_cast<std::size_t>(place);
        above[axis] = std::min(below[axis] + 1, static_cast<std::size_t>(last));
        share[axis] = place - static_cast<double>(below[axis]);
    }
    const auto cell = [&](std::size_t x, std::size_t y, std::size_t z) {
        return cells[(z * static_cast<std::size_t>(size_[1]) + y) * static_cast<std::size_t>(size_[0]) + x];
    };
    const auto alongX = [&](std::size_t y, std::size_t z) {
        return glm::mix(cell(below[0], y, z), cell(above[0], y, z), share[0]);
    };
    const auto alongY = [&](std::size_t z) {
        return glm::mix(alongX(below[1], z), alongX(above[1], z), share[1]);
    };
    return glm::mix(alongY(below[2]), alongY(above[2]), share[2]);
}

VolumeMatter VolumeField::at(const glm::dvec3& inLayer) const {
    const double extinct = extinction(inLayer);
    // Most of a plot's box is empty, and a colour takes longer than all else.
    if (!(extinct > 0.0)) return {};
    return {extinct, color(t(inLayer))};
}

std::vector<HalfSpace> VolumeField::within() const {
    std::vector<HalfSpace> sides;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        glm::dvec3 normal(0.0);
        normal[static_cast<int>(axis)] = 1.0;
        const double low = static_cast<double>(first_[axis]) * edge_ - 1.0;
        const double high = low + static_cast<double>(size_[axis]) * edge_;
        sides.push_back({normal, low});
        sides.push_back({-normal, -high});
    }
    return sides;
}

VolumeField volumeOf(const render::Scene& scene, std::size_t layer, const ParticlesStyle& style) {
    const auto& colorBy = scene.view.layers[layer].colorBy;
    const auto& data = scene.layers[layer];
    if (!colorBy || data.values == nullptr) return {*data.step, style};
    const auto map = colorMapOf(*colorBy);
    return {*data.step, style, data.values.get(), &map};
}

}  // namespace mote::reference
