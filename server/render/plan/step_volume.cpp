// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/step_volume.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/combinable.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "protocol/base/mote_check.h"
#include "server/render/plan/matter/cell_grid.h"
#include "server/render/plan/matter/leaves_by_cell.h"
#include "server/render/plan/matter/thick_matter.h"
#include "storage/storage_error.h"

namespace mote::render {
namespace {

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

/// The mean of the square of what is interpolated between cells' centres, around each of them: weighted by
/// how much it counts there. Beyond the outermost cells their values hold. Polynomials of the third degree
/// along each axis, so two places of Gauss in each interval tell it exactly.
class SquaresAround {
  public:
    SquaresAround(const std::vector<float>& cells, const glm::uvec3& size)
        : cells_(cells), size_(size), fromBelow_(cells.size(), 0.0F), fromAbove_(cells.size(), 0.0F) {
        // An interval lies above the sheet of its number less one.
        oneapi::tbb::parallel_for(0U, size.z + 1, [&](std::uint32_t z) { addIntervals(z); });
    }
    float operator[](std::size_t cell) const { return fromBelow_[cell] + fromAbove_[cell]; }

  private:
    /// The intervals between two sheets of centres, along z.
    void addIntervals(std::uint32_t z) {
        for (std::uint32_t y = 0; y <= size_.y; ++y) {
            for (std::uint32_t x = 0; x <= size_.x; ++x) addInterval({x, y, z});
        }
    }

    /// Corner i of an interval, x fastest, lies in the cell of the interval's number less 1, or in that of
    /// its number; there may be no such cell.
    bool isCell(const glm::uvec3& interval, unsigned i) const {
        for (int axis = 0; axis < 3; ++axis) {
            if (interval[axis] == ((i >> axis & 1U) == 0U ? 0U : size_[axis])) return false;
        }
        return true;
    }
    std::size_t cellAt(const glm::uvec3& interval, unsigned i) const {
        const glm::uvec3 corner = interval + glm::uvec3(i & 1U, i >> 1 & 1U, i >> 2);
        const glm::uvec3 cell = glm::clamp(corner, glm::uvec3(1), size_) - 1U;
        return (std::size_t{cell.z} * size_.y + cell.y) * size_.x + cell.x;
    }

    void addInterval(const glm::uvec3& interval) {
        std::array<float, 8> values{};
        for (unsigned i = 0; i < 8; ++i) values[i] = cells_[cellAt(interval, i)];
        if (std::none_of(values.begin(), values.end(), [](float value) { return value > 0.0F; })) return;
        mixAlongAxes(values);
        for (float& value : values) value *= 0.125F * value;
        mixAlongAxes(values);
        // Intervals above and below a sheet of centres may be added at once: each has a sum of its own there.
        for (unsigned i = 0; i < 8; ++i) {
            if (isCell(interval, i)) (i < 4 ? fromAbove_ : fromBelow_)[cellAt(interval, i)] += values[i];
        }
    }

    /// From the ends of an interval to its places of Gauss, and back.
    static void mixAlongAxes(std::array<float, 8>& values) {
        constexpr float near = 0.78867513F, far = 0.21132487F;  // (1 + 1 / sqrt(3)) / 2, and the rest
        for (std::size_t axis = 1; axis < 8; axis *= 2) {
            for (std::size_t i = 0; i < 8; ++i) {
                if ((i & axis) != 0) continue;
                const float low = values[i], high = values[i | axis];
                values[i] = near * low + far * high;
                values[i | axis] = far * low + near * high;
            }
        }
    }

    const std::vector<float>& cells_;
    const glm::uvec3 size_;
    std::vector<float> fromBelow_, fromAbove_;
};

/// docs/PICTURE.md, "Volume": the roots, such that what lies around a cell's centre is what the cell holds.
std::vector<float> rootsOf(const std::vector<double>& extinction, const glm::uvec3& size) {
    std::vector<float> roots(extinction.size());
    std::transform(extinction.begin(), extinction.end(), roots.begin(),
                   [](double one) { return static_cast<float>(std::cbrt(one)); });
    const SquaresAround squares(roots, size);
    for (std::size_t cell = 0; cell < roots.size(); ++cell) {
        if (roots[cell] > 0.0F) roots[cell] *= std::cbrt(roots[cell] * roots[cell] / squares[cell]);
    }
    return roots;
}

/// What is summed up in the cells.
class Summation {
  public:
    /// `values`: of the leaves, that colour them; null: their t does.
    Summation(const storage::ParticleStep& step, const TransferFunction& transfer, const Curve& fraction,
              const PointValues* values)
        : step_(step),
          leaves_(step.leaves()),
          byCell_(step),
          fraction_(fraction),
          values_(values),
          matter_(leaves_.size()) {
        MOTE_CHECK(values == nullptr || (values->byLeaf && values->codes.size() == leaves_.size()));
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leaves_.size()), [&](const auto& block) {
            LeafMatter matter(transfer, step.logDensity());
            for (std::size_t leaf = block.begin(); leaf < block.end(); ++leaf) {
                if (leaves_.density[leaf] > 0.0F && matter.look(leaves_.density[leaf]))
                    matter_[leaf] = {static_cast<float>(matter.extinction()), static_cast<float>(matter.t())};
            }
        });
    }

    StepVolume make() {
        if (!findBox()) return {};
        chooseLevel();
        const std::size_t count = grid_.count();
        extinction_.assign(count, 0.0);
        colored_.assign(count, 0.0);
        moment_.assign(count, 0.0);
        forSeen([&](std::size_t leaf, const CellAt& at) {
            const bool colored = hasColor(leaf);
            const double place = colored ? colorOf(leaf) : 0.0;
            grid_.forCells(at, [&](std::size_t cell, double part) {
                const double extinction = part * matter_[leaf].extinction;
                extinction_[cell] += extinction;
                if (!colored) return;
                colored_[cell] += extinction;
                moment_[cell] += extinction * place;
            });
        });
        return finish();
    }

  private:
    /// What a leaf shows; nothing where its extinction is 0.
    struct Shown {
        float extinction = 0.0F, t = 0.0F;
    };

    bool seen(std::size_t leaf) const { return matter_[leaf].extinction > 0.0F; }

    /// On all threads; leaves of one of the grid's cells one after the other.
    template <class Visit>
    void forSeen(const Visit& visit) const {
        byCell_.forEach(grid_.level, [&](std::size_t leaf, const CellAt& at) {
            if (seen(leaf)) visit(leaf, at);
        });
    }

    /// Whether a leaf may lie in the volume: one without a value has no colour there.
    bool hasColor(std::size_t leaf) const { return values_ == nullptr || values_->codes[leaf] != noValue; }

    double colorOf(std::size_t leaf) const {
        return values_ == nullptr ? matter_[leaf].t
                                  : static_cast<double>(values_->codes[leaf]) / greatestValue;
    }

    /// Around leaves, in cells of the deepest level.
    struct Box {
        glm::uvec3 low{~0U}, high{0};
        unsigned finest = 0;  ///< level

        void add(const CellAt& at) {
            const glm::uvec3 shift(deepestLevel - at.level);
            *this = with({at.place << shift, (at.place + 1U) << shift, at.level});
        }
        Box with(const Box& other) const {
            return {glm::min(low, other.low), glm::max(high, other.high), std::max(finest, other.finest)};
        }
    };

    /// Around all leaves that are seen; false if none is.
    bool findBox() {
        tbb::combinable<Box> boxes;
        byCell_.forEach(deepestLevel, [&](std::size_t leaf, const CellAt& at) {
            if (seen(leaf)) boxes.local().add(at);
        });
        const Box box = boxes.combine([](const Box& one, const Box& other) { return one.with(other); });
        low_ = box.low;
        high_ = box.high;
        finest_ = box.finest;
        return high_.x > 0;
    }

    /// The finest of which there are no more than the step's volume has, and none finer than the leaves.
    void chooseLevel() {
        const std::uint64_t side = std::max(step_.volumeSize(), 1U);
        const std::uint64_t most = std::min(side * side * side, StepVolume::mostCells);
        unsigned level = std::min({finest_, StepVolume::deepest, unsigned{deepestLevel}});
        do {
            grid_ = CellGrid::around(low_, high_, level);
        } while (grid_.count() > most && level-- > 0);
    }

    StepVolume finish() {
        StepVolume volume{.level = grid_.level, .first = grid_.low, .size = grid_.size()};
        shareLeaves(volume);
        volume.t.assign(extinction_.size(), 0.0F);
        grid_.forEach([&](const glm::uvec3&, std::size_t at) {
            if (colored_[at] > 0.0) volume.t[at] = static_cast<float>(moment_[at] / colored_[at]);
        });
        spreadColors(volume);
        if (!volume.share.empty()) {
            const std::vector<double> all = extinction_;
            takeShares(volume);
            tellHeld(all, volume);
        }
        volume.root = rootsOf(extinction_, volume.size);
        return volume;
    }

    /// Cells without matter take the colour of what is around them, by its extinction.
    void spreadColors(StepVolume& volume) const {
        grid_.forEach([&](const glm::uvec3& cell, std::size_t at) {
            if (colored_[at] > 0.0) return;
            double sum = 0.0, moment = 0.0;
            grid_.forAround(cell, [&](std::size_t near) {
                sum += colored_[near];
                moment += moment_[near];
            });
            if (sum > 0.0) volume.t[at] = static_cast<float>(moment / sum);
        });
    }

    /// `all`: what extinction was before shares were taken.
    void tellHeld(const std::vector<double>& all, StepVolume& volume) const {
        volume.held.assign(all.size(), 0.0F);
        grid_.forEach([&](const glm::uvec3& cell, std::size_t at) {
            double sum = 0.0, held = 0.0;
            grid_.forAround(cell, [&](std::size_t near) {
                sum += all[near];
                held += extinction_[near];
            });
            if (sum > 0.0) volume.held[at] = static_cast<float>(held / sum);
        });
    }

    /// One without a colour has none.
    void shareLeaves(StepVolume& volume) {
        volume.share = thickMatter(step_, shownLeaves(), grid_, low_, high_);
        for (std::size_t leaf = 0; values_ != nullptr && leaf < leaves_.size(); ++leaf)
            if (seen(leaf) && !hasColor(leaf)) volume.share[leaf] = 0;
        if (std::all_of(volume.share.begin(), volume.share.end(), [](auto share) { return share == 255; }))
            volume.share = {};
    }

    ShownLeaves shownLeaves() const {
        ShownLeaves shown{std::vector<std::uint8_t>(leaves_.size(), 0),
                          std::numeric_limits<float>::infinity(), std::vector<float>(leaves_.size(), 0.0F)};
        // Leaves ascend in density.
        for (std::size_t leaf = leaves_.size(); leaf-- > 0;) {
            shown.seen[leaf] = seen(leaf) ? 1 : 0;
            if (seen(leaf)) shown.thinnest = leaves_.density[leaf];
        }
        const LogDensity scale = step_.logDensity();
        tbb::parallel_for(std::size_t{0}, leaves_.size(), [&](std::size_t leaf) {
            const float density = leaves_.density[leaf];
            if (density < shown.thinnest)
                shown.points[leaf] = static_cast<float>(fraction_(scale.ofLeaf(density)));
        });
        return shown;
    }

    void takeShares(const StepVolume& volume) {
        std::fill(extinction_.begin(), extinction_.end(), 0.0);
        forSeen([&](std::size_t leaf, const CellAt& at) {
            const double extinction = volume.shareOf(leaf) * matter_[leaf].extinction;
            grid_.forCells(at,
                           [&](std::size_t cell, double part) { extinction_[cell] += part * extinction; });
        });
    }

    const storage::ParticleStep& step_;
    const storage::Leaves leaves_;
    const LeavesByCell byCell_;
    const Curve& fraction_;
    const PointValues* const values_;
    std::vector<Shown> matter_;    // by leaf
    glm::uvec3 low_{0}, high_{0};  // around all leaves that are seen, in cells of the deepest level
    CellGrid grid_;
    unsigned finest_ = 0;
    std::vector<double> extinction_, colored_;  // by cell; the second of leaves that have a colour
    std::vector<double> moment_;                // the second times the colour's place in the map
};

}  // namespace

glm::dmat4 StepVolume::toPlot() const {
    const double edge = std::ldexp(1.0, -static_cast<int>(level));
    return glm::scale(glm::translate(glm::dmat4(1.0), edge * glm::dvec3(first)), edge * glm::dvec3(size));
}

StepVolume::PointTone StepVolume::toneAt(const glm::dvec3& inPlot) const {
    const glm::dvec3 inCells = std::ldexp(1.0, static_cast<int>(level)) * inPlot - glm::dvec3(first);
    const glm::dvec3 last = glm::dvec3(size) - 1.0;
    const glm::dvec3 place = glm::clamp(inCells - 0.5, glm::dvec3(0.0), last);
    const glm::uvec3 low(place), high = glm::min(low + 1U, size - 1U);
    const glm::dvec3 far = place - glm::dvec3(low);
    PointTone tone{0.0, 0.0};
    for (unsigned corner = 0; corner < 8; ++corner) {
        glm::uvec3 cell = low;
        double part = 1.0;
        for (int axis = 0; axis < 3; ++axis) {
            const bool beyond = (corner >> axis & 1U) != 0;
            part *= beyond ? far[axis] : 1.0 - far[axis];
            if (beyond) cell[axis] = high[axis];
        }
        const std::size_t at = index(cell.x, cell.y, cell.z);
        tone.held += part * (held.empty() ? 1.0 : double{held[at]});
        tone.t += part * double{t[at]};
    }
    return tone;
}

std::uint64_t StepVolume::bytes() const {
    return sizeof(float) * (root.capacity() + t.capacity() + held.capacity()) + share.capacity();
}

StepVolume stepVolume(const storage::ParticleStep& step, const TransferFunction& transfer,
                      const Curve& fraction, const PointValues* values) {
    return Summation(step, transfer, fraction, values).make();
}

StepVolume roughStepVolume(const storage::ParticleStep& step, const TransferFunction& transfer) {
    const std::uint32_t side = step.volumeSize();
    const auto densities = step.volume();
    if (side == 0 || !std::has_single_bit(side) || densities.size() != std::size_t{side} * side * side) {
        throw storage::StorageError(
            Error{ErrorCode::corrupt, "/volume/density", "the volume's size is not its shape"});
    }
    StepVolume grid{.level = static_cast<unsigned>(std::countr_zero(side)), .size = glm::uvec3(side)};
    std::vector<double> extinction(densities.size(), 0.0);
    grid.t.assign(densities.size(), 0.0F);
    LeafMatter matter(transfer, step.logDensity());
    bool any = false;
    for (std::size_t i = 0; i < densities.size(); ++i) {
        if (!(densities[i] > 0.0F) || !matter.look(densities[i])) continue;
        extinction[i] = matter.extinction();
        grid.t[i] = static_cast<float>(matter.t());
        any = true;
    }
    if (!any) return {};
    grid.root = rootsOf(extinction, grid.size);
    return grid;
}

}  // namespace mote::render
