// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/step_volume.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "server/render/plan/octree_cell.h"
#include "storage/storage_error.h"

namespace mote::render {
namespace {

// How far the matter in and around a cell spreads along all three axes (Spread): below the one it is too thin
// to be a volume, above the other it is one. Matter that is even everywhere has 2/9, a sheet 1/15 or less.
constexpr double thinnest = 0.10, thickest = 0.16;

/// How the weights of 3 x 3 x 3 cells are spread about their middle, in cells.
class Spread {
  public:
    void add(const glm::dvec3& place, double weight) {
        weight_ += weight;
        first_ += weight * place;
        square_ += weight * place * place;
        mixed_ += weight * glm::dvec3(place.y * place.z, place.z * place.x, place.x * place.y);
    }
    /// 1 / (1/a + 1/b + 1/c), of the variances along the principal axes: small where one of them is.
    double harmonic() const {
        if (!(weight_ > 0.0)) return 0.0;
        const glm::dvec3 mean = first_ / weight_, v = square_ / weight_ - mean * mean;
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

/// The extinction of leaf after leaf; equal densities, common in a run of equal weights, are looked up once.
class LeafMatter {
  public:
    LeafMatter(const TransferFunction& transfer, const LogDensity& scale)
        : transfer_(transfer), scale_(scale) {}
    /// Whether anything of such a leaf is seen.
    bool look(float density) {
        if (density != density_) {
            density_ = density;
            t_ = scale_.ofLeaf(density);
            extinction_ = transfer_.extinction(t_);
        }
        return extinction_ > 0.0;
    }
    double t() const { return t_; }
    double extinction() const { return extinction_; }

  private:
    const TransferFunction& transfer_;
    LogDensity scale_;
    float density_ = -1.0F;
    double t_ = 0.0, extinction_ = 0.0;
};

/// Cells [low, high) of a level, along each axis.
struct CellBox {
    glm::uvec3 low{0}, high{0};

    glm::uvec3 size() const { return high - low; }
    std::uint64_t count() const { return std::uint64_t{size().x} * size().y * size().z; }
};

/// What is summed up in the cells.
class Summation {
  public:
    Summation(const storage::ParticleStep& step, const TransferFunction& transfer)
        : step_(step), nodes_(step.nodes()), leaves_(step.leaves()), transfer_(transfer) {}

    StepVolume make() {
        if (!findBox()) return {};
        chooseLevel();
        const std::size_t count = box_.count();
        extinction_.assign(count, 0.0);
        moment_.assign(count, 0.0);
        forSeen([&](std::size_t leaf, const LeafMatter& matter) {
            forCells(leaf, [&](std::size_t cell, double part) {
                extinction_[cell] += part * matter.extinction();
                moment_[cell] += part * matter.extinction() * matter.t();
            });
        });
        findShares();
        return finish();
    }

  private:
    template <class Visit>
    void forSeen(const Visit& visit) {
        LeafMatter matter(transfer_, step_.logDensity());
        for (std::size_t leaf = 0; leaf < leaves_.size(); ++leaf) {
            if (leaves_.density[leaf] > 0.0F && matter.look(leaves_.density[leaf])) visit(leaf, matter);
        }
    }

    /// Around all leaves that are seen, in cells of the deepest level.
    bool findBox() {
        glm::uvec3 low(~0U), high(0);
        forSeen([&](std::size_t leaf, const LeafMatter&) {
            const auto node = leaves_.node[leaf];
            const unsigned level = std::min<unsigned>(nodes_.level[node], deepestLevel);
            const unsigned shift = deepestLevel - level;
            const glm::uvec3 place = cellPlace(nodes_.morton[node]);
            low = glm::min(low, place << glm::uvec3(shift));
            high = glm::max(high, (place + 1U) << glm::uvec3(shift));
            finest_ = std::max(finest_, level);
        });
        whole_ = {low, high};
        return high.x > 0;
    }

    /// The cells of a level around the whole, and one more on each side.
    CellBox boxAt(unsigned level) const {
        const glm::uvec3 shift(deepestLevel - level);
        const std::uint32_t side = 1U << level;
        CellBox box{whole_.low >> shift, ((whole_.high - 1U) >> shift) + 1U};
        box.low -= glm::min(box.low, glm::uvec3(1));
        box.high = glm::min(box.high + 1U, glm::uvec3(side));
        return box;
    }

    /// The finest of which there are no more than the step's volume has, and none finer than the leaves.
    void chooseLevel() {
        const std::uint64_t side = std::max(step_.volumeSize(), 1U);
        const std::uint64_t most = std::min(side * side * side, StepVolume::mostCells);
        level_ = std::min({finest_, StepVolume::deepest, unsigned{deepestLevel}});
        while (level_ > 0 && boxAt(level_).count() > most) --level_;
        box_ = boxAt(level_);
    }

    std::size_t index(const glm::uvec3& cell) const {
        const glm::uvec3 at = cell - box_.low, size = box_.size();
        return (std::size_t{at.z} * size.y + at.y) * size.x + at.x;
    }

    /// Calls visit(cell, share of the cell) for each cell that a leaf lies in.
    template <class Visit>
    void forCells(std::size_t leaf, const Visit& visit) const {
        const auto node = leaves_.node[leaf];
        const unsigned level = std::min<unsigned>(nodes_.level[node], deepestLevel);
        const glm::uvec3 place = cellPlace(nodes_.morton[node]);
        const unsigned down = level > level_ ? level - level_ : 0, up = level_ > level ? level_ - level : 0;
        const glm::uvec3 from = (place >> glm::uvec3(down)) << glm::uvec3(up);
        const glm::uvec3 low = glm::max(from, box_.low), high = glm::min(from + (1U << up), box_.high);
        const double part = std::ldexp(1.0, -3 * static_cast<int>(down));
        for (std::uint32_t z = low.z; z < high.z; ++z) {
            for (std::uint32_t y = low.y; y < high.y; ++y) {
                for (std::uint32_t x = low.x; x < high.x; ++x) visit(index({x, y, z}), part);
            }
        }
    }

    /// The weight of all leaves in each cell, over its share of the plot.
    std::vector<double> densities() const {
        std::vector<double> sums(extinction_.size(), 0.0);
        for (std::size_t leaf = 0; leaf < leaves_.size(); ++leaf) {
            const double density = leaves_.density[leaf];
            forCells(leaf, [&](std::size_t cell, double part) { sums[cell] += part * density; });
        }
        return sums;
    }

    /// Calls visit(cell) for the cells around one, and for itself.
    template <class Visit>
    void forAround(const glm::uvec3& cell, const Visit& visit) const {
        const glm::uvec3 size = box_.size();
        const glm::uvec3 low = cell - glm::min(cell, glm::uvec3(1)), high = glm::min(cell + 2U, size);
        for (std::uint32_t z = low.z; z < high.z; ++z) {
            for (std::uint32_t y = low.y; y < high.y; ++y) {
                for (std::uint32_t x = low.x; x < high.x; ++x)
                    visit((std::size_t{z} * size.y + y) * size.x + x);
            }
        }
    }

    template <class Visit>
    void forEach(const Visit& visit) const {
        const glm::uvec3 size = box_.size();
        tbb::parallel_for(0U, size.z, [&](std::uint32_t z) {
            for (std::uint32_t y = 0; y < size.y; ++y) {
                for (std::uint32_t x = 0; x < size.x; ++x)
                    visit(glm::uvec3(x, y, z), (std::size_t{z} * size.y + y) * size.x + x);
            }
        });
    }

    /// A cell is a volume where matter spreads to all sides of it, or of one beside it: sheets and threads
    /// are points. Beyond the plot it goes on as it is.
    void findShares() {
        const auto density = densities();
        std::vector<float> thick(density.size(), 0.0F);
        const glm::ivec3 size(box_.size());
        forEach([&](const glm::uvec3& cell, std::size_t at) {
            if (!(extinction_[at] > 0.0)) return;
            Spread spread;
            for (int i = 0; i < 27; ++i) {
                const glm::ivec3 away(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
                const glm::ivec3 near = glm::clamp(glm::ivec3(cell) + away, glm::ivec3(0), size - 1);
                spread.add(glm::dvec3(away), density[(static_cast<std::size_t>(near.z) * box_.size().y +
                                                      static_cast<std::size_t>(near.y)) *
                                                         box_.size().x +
                                                     static_cast<std::size_t>(near.x)]);
            }
            thick[at] = static_cast<float>(
                std::clamp((spread.harmonic() - thinnest) / (thickest - thinnest), 0.0, 1.0));
        });
        shares_.assign(thick.size(), 0);
        forEach([&](const glm::uvec3& cell, std::size_t at) {
            if (!(extinction_[at] > 0.0)) return;
            float most = 0.0F;
            forAround(cell, [&](std::size_t near) { most = std::max(most, thick[near]); });
            shares_[at] = static_cast<std::uint8_t>(std::lround(255.0F * most));
        });
    }

    StepVolume finish() {
        StepVolume volume{.level = level_, .first = box_.low, .size = box_.size()};
        shareLeaves(volume);
        volume.extinction.assign(extinction_.begin(), extinction_.end());
        volume.t.assign(extinction_.size(), 0.0F);
        forEach([&](const glm::uvec3&, std::size_t at) {
            if (extinction_[at] > 0.0) volume.t[at] = static_cast<float>(moment_[at] / extinction_[at]);
        });
        spreadColors(volume);
        if (!volume.share.empty()) takeShares(volume);
        return volume;
    }

    /// Cells without matter take the colour of what is around them, by its extinction.
    void spreadColors(StepVolume& volume) const {
        forEach([&](const glm::uvec3& cell, std::size_t at) {
            if (extinction_[at] > 0.0) return;
            double sum = 0.0, moment = 0.0;
            forAround(cell, [&](std::size_t near) {
                sum += extinction_[near];
                moment += moment_[near];
            });
            if (sum > 0.0) volume.t[at] = static_cast<float>(moment / sum);
        });
    }

    /// A leaf that lies in several cells has the greatest share of theirs.
    void shareLeaves(StepVolume& volume) {
        bool thin = false;
        volume.share.assign(leaves_.size(), 255);
        forSeen([&](std::size_t leaf, const LeafMatter&) {
            std::uint8_t most = 0;
            forCells(leaf, [&](std::size_t cell, double) { most = std::max(most, shares_[cell]); });
            volume.share[leaf] = most;
            thin = thin || most < 255;
        });
        if (!thin) volume.share = {};
    }

    void takeShares(StepVolume& volume) {
        std::fill(extinction_.begin(), extinction_.end(), 0.0);
        forSeen([&](std::size_t leaf, const LeafMatter& matter) {
            const double extinction = volume.shareOf(leaf) * matter.extinction();
            forCells(leaf, [&](std::size_t cell, double part) { extinction_[cell] += part * extinction; });
        });
        volume.extinction.assign(extinction_.begin(), extinction_.end());
    }

    const storage::ParticleStep& step_;
    const storage::OctreeNodes nodes_;
    const storage::Leaves leaves_;
    const TransferFunction& transfer_;
    CellBox whole_, box_;
    unsigned level_ = 0, finest_ = 0;
    std::vector<double> extinction_, moment_;  // by cell; the second times t
    std::vector<std::uint8_t> shares_;
};

}  // namespace

glm::dmat4 StepVolume::toPlot() const {
    const double edge = std::ldexp(1.0, -static_cast<int>(level));
    return glm::scale(glm::translate(glm::dmat4(1.0), edge * glm::dvec3(first)), edge * glm::dvec3(size));
}

std::uint64_t StepVolume::bytes() const {
    return sizeof(float) * (extinction.capacity() + t.capacity()) + share.capacity();
}

StepVolume stepVolume(const storage::ParticleStep& step, const TransferFunction& transfer) {
    return Summation(step, transfer).make();
}

StepVolume roughStepVolume(const storage::ParticleStep& step, const TransferFunction& transfer) {
    const std::uint32_t side = step.volumeSize();
    const auto densities = step.volume();
    if (side == 0 || !std::has_single_bit(side) || densities.size() != std::size_t{side} * side * side) {
        throw storage::StorageError(
            Error{ErrorCode::corrupt, "/volume/density", "the volume's size is not its shape"});
    }
    StepVolume grid{.level = static_cast<unsigned>(std::countr_zero(side)), .size = glm::uvec3(side)};
    grid.extinction.assign(densities.size(), 0.0F);
    grid.t.assign(densities.size(), 0.0F);
    LeafMatter matter(transfer, step.logDensity());
    bool any = false;
    for (std::size_t i = 0; i < densities.size(); ++i) {
        if (!(densities[i] > 0.0F) || !matter.look(densities[i])) continue;
        grid.extinction[i] = static_cast<float>(matter.extinction());
        grid.t[i] = static_cast<float>(matter.t());
        any = true;
    }
    return any ? grid : StepVolume{};
}

}  // namespace mote::render
