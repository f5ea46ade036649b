// SPDX-License-Identifier: GPL-3.0-or-later
//
// A selection is made ready for a step as a tree of conditions; then each block of points goes through the
// tree by itself.
#include <fmt/format.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/quantity/plot_axes.h"
#include "protocol/scene/selection.h"
#include "storage/beam/quantity_reader.h"
#include "storage/numbers/id_set.h"
#include "storage/numbers/point_mask.h"
#include "storage/numbers/point_places.h"
#include "storage/numbers/polygon_index.h"
#include "storage/numbers/range_kernel.h"
#include "storage/numbers/run_steps.h"
#include "storage/numbers/scan.h"
#include "storage/numbers/select_points.h"

namespace mote::storage {
namespace {

/// Whether a particle is one of the outermost of a step in a plane of phase space (docs/SELECTIONS.md,
/// "Selections"): its single-particle emittance about the step's own rms ellipse.
struct OutermostTest {
    double meanQ = 0.0, meanP = 0.0;
    double qq = 0.0, qp = 0.0, pp = 0.0;  ///< second moments about the means
    double threshold = 0.0;               ///< of emittance times the rms emittance; what equals it is one
    bool none = true;

    /// <p^2> q^2 - 2 <q p> q p + <q^2> p^2, q and p about their means: the emittance of the ellipse through
    /// the particle, times the rms emittance.
    double emittance(double q, double p) const {
        q -= meanQ;
        p -= meanP;
        return pp * q * q - 2.0 * qp * q * p + qq * p * p;
    }
    bool operator()(double q, double p) const { return !none && emittance(q, p) >= threshold; }
};

// The threshold is found as a digit after the other of the emittances' own bits: the weight of each value of
// the first 16 bits, then of the next ones among those that share the first. So no emittance is ever stored.
constexpr int digitBits = 16;
constexpr std::size_t digits = std::size_t{1} << digitBits;
/// Points are summed in so many parts at most, one after the other: the same sums on any number of threads.
constexpr std::uint64_t mostGridParts = 64;

/// A value that orders as the emittance, which is not NaN, does.
std::uint64_t keyOf(double emittance) {
    const auto bits = std::bit_cast<std::uint64_t>(emittance);
    return (bits >> 63) != 0 ? ~bits : bits | (std::uint64_t{1} << 63);
}
double ofKey(std::uint64_t key) {
    return std::bit_cast<double>((key >> 63) != 0 ? key & ~(std::uint64_t{1} << 63) : ~key);
}

struct Moments {
    double weight = 0.0, q = 0.0, p = 0.0, qq = 0.0, qp = 0.0, pp = 0.0;
};

class Plane {
  public:
    Plane(const ParticleColumns& columns, QuantityReader reader, bool weighted,
          const std::function<bool()>& cancelled)
        : reader_(std::move(reader)),
          weighted_(weighted),
          cancelled_(cancelled),
          points_(columns.pointCount()) {
        const auto blocks = blockCount(points_);
        blocksAPart_ = std::max<std::uint64_t>(1, (blocks + mostGridParts - 1) / mostGridParts);
        parts_ = (blocks + blocksAPart_ - 1) / blocksAPart_;
    }

    std::uint64_t parts() const { return parts_; }

    /// Calls take(part, q, p, weight) with all that count; those of a part one after the other.
    template <class Take>
    bool visit(const Take& take) const {
        std::atomic<bool> stopped{false};
        const bool whole = forBlocks(parts_, cancelled_, [&](std::uint64_t part) {
            QuantityReader::Scratch scratch;
            std::array<std::vector<double>, 3> values;
            for (auto& one : values) one.resize(blockPoints, 1.0);
            const auto last = std::min((part + 1) * blocksAPart_, blockCount(points_));
            for (auto block = part * blocksAPart_; block < last; ++block) {
                if (stopped) return;
                if (cancelled_ && cancelled_()) {
                    stopped = true;
                    return;
                }
                const auto range = pointsOfBlock(block, points_);
                const auto count = static_cast<std::size_t>(range.count);
                std::array<std::span<double>, 3> out;
                for (std::size_t i = 0; i < out.size(); ++i) out[i] = std::span(values[i]).first(count);
                reader_.read(range.begin, count, scratch, std::span(out).first(weighted_ ? 3 : 2));
                for (std::size_t i = 0; i < count; ++i) {
                    const double q = values[0][i], p = values[1][i], weight = values[2][i];
                    if (weight > 0.0 && std::isfinite(weight) && std::isfinite(q) && std::isfinite(p))
                        take(part, q, p, weight);
                }
            }
        });
        return whole && !stopped;
    }

  private:
    QuantityReader reader_;
    bool weighted_;
    const std::function<bool()>& cancelled_;
    std::uint64_t points_, parts_ = 0, blocksAPart_ = 1;
};

/// Means and second moments about them.
bool findEllipse(const Plane& plane, OutermostTest& test, double& weight) {
    std::vector<Moments> parts(plane.parts());
    const auto sum = [&](auto&& add) {
        parts.assign(plane.parts(), {});
        return plane.visit(
            [&](std::uint64_t part, double q, double p, double w) { add(parts[part], q, p, w); });
    };
    const auto total = [&](double Moments::*member) {
        double all = 0.0;
        for (const auto& part : parts) all += part.*member;
        return all;
    };
    if (!sum([](Moments& m, double q, double p, double w) {
            m.weight += w;
            m.q += w * q;
            m.p += w * p;
        }))
        return false;
    weight = total(&Moments::weight);
    if (!(weight > 0.0)) return true;
    test.meanQ = total(&Moments::q) / weight;
    test.meanP = total(&Moments::p) / weight;
    if (!sum([&](Moments& m, double q, double p, double w) {
            q -= test.meanQ;
            p -= test.meanP;
            m.qq += w * q * q;
            m.qp += w * q * p;
            m.pp += w * p * p;
        }))
        return false;
    test.qq = total(&Moments::qq) / weight;
    test.qp = total(&Moments::qp) / weight;
    test.pp = total(&Moments::pp) / weight;
    return true;
}

/// The greatest emittance from which on there is so much weight.
bool findThreshold(const Plane& plane, double wanted, OutermostTest& test) {
    std::uint64_t known = 0;  // the first digits of the threshold's key
    std::vector<double> weights;
    for (int shift = 64 - digitBits; shift >= 0; shift -= digitBits) {
        weights.assign(plane.parts() * digits, 0.0);
        const bool whole = plane.visit([&](std::uint64_t part, double q, double p, double w) {
            const auto key = keyOf(test.emittance(q, p));
            if (shift + digitBits < 64 && key >> (shift + digitBits) != known) return;
            weights[part * digits + ((key >> shift) & (digits - 1))] += w;
        });
        if (!whole) return false;
        // The last digit with any weight is taken where rounding leaves the sum short.
        std::size_t chosen = digits;
        double beyond = 0.0;
        for (std::size_t digit = digits; digit-- > 0;) {
            double own = 0.0;
            for (std::uint64_t part = 0; part < plane.parts(); ++part) own += weights[part * digits + digit];
            if (!(own > 0.0)) continue;
            chosen = digit;
            if (beyond + own >= wanted) break;
            beyond += own;
        }
        known = known << digitBits | chosen;
        wanted -= beyond;
    }
    test.threshold = ofKey(known);
    return true;
}

/// The columns of a plane: the place and the momentum along it.
std::span<const std::string> planeColumns(char plane) {
    static const std::array<std::array<std::string, 2>, 3> names{{{"x", "px"}, {"y", "py"}, {"z", "pz"}}};
    return names[static_cast<std::size_t>(plane - 'x')];
}

/// The test of so great a share of the step's weight. A particle without weight above zero, or whose place or
/// momentum is not finite, counts neither in the moments nor in the share. Errors: cancelled; at the name,
/// notFound. Throws StorageError.
Result<OutermostTest> findOutermost(const Selection::Outermost& wanted, const StepNumbers& step,
                                    const std::function<bool()>& cancelled) {
    const auto names = planeColumns(wanted.plane);
    std::vector<std::string> read(names.begin(), names.end());
    const bool weighted = step.columns->find("weight").has_value();
    if (weighted) read.emplace_back("weight");
    MOTE_ASSIGN_OR_RETURN(auto reader, QuantityReader::make(*step.columns, step.context, read));
    const Plane plane(*step.columns, std::move(reader), weighted, cancelled);
    OutermostTest test;
    double weight = 0.0;
    if (!findEllipse(plane, test, weight)) return wasCancelled();
    if (!(weight > 0.0) || !(wanted.share > 0.0)) return test;
    if (!findThreshold(plane, wanted.share * weight, test)) return wasCancelled();
    test.none = false;
    return test;
}

/// Something that points of one step meet or not, asked of a block of them at once
/// (storage/numbers/scan.h). A tree of conditions is a selection that was made ready for a step. Immutable;
/// any number of threads, each with a Scratch of its own. What a condition reads must outlive it.
class PointCondition {
  public:
    /// A thread's memory.
    struct Scratch {
        QuantityReader::Scratch reader;
        std::array<std::vector<double>, axesOfPlot> values;  ///< of quantities
    };

    virtual ~PointCondition() = default;
    /// Takes the points out of `words`, a bit for each of the block from its first, that do not meet it.
    /// Throws StorageError.
    virtual void keep(PointRange block, std::span<std::uint64_t> words, Scratch& scratch) const = 0;
};

using PointConditions = std::vector<std::unique_ptr<const PointCondition>>;
using MadeCondition = Result<std::unique_ptr<const PointCondition>>;

using Scratch = PointCondition::Scratch;
using Words = std::span<std::uint64_t>;
using BlockWords = std::array<std::uint64_t, blockPoints / PointMask::wordBits>;

/// Keeps the points for which `test`, given their place in the block, is true; asks only for those that are
/// still there.
template <class Test>
void keepWhere(Words words, const Test& test) {
    for (std::size_t i = 0; i < words.size(); ++i) {
        auto kept = words[i];
        for (auto word = words[i]; word != 0; word &= word - 1) {
            const auto bit = static_cast<std::size_t>(std::countr_zero(word));
            if (!test(i * PointMask::wordBits + bit)) kept &= ~(std::uint64_t{1} << bit);
        }
        words[i] = kept;
    }
}

Result<QuantityReader> readerOf(const StepNumbers& step, std::span<const std::string> names,
                                std::string_view field) {
    auto reader = QuantityReader::make(*step.columns, step.context, names);
    if (reader.ok()) return reader;
    const auto& error = reader.error();  // at the name
    return Error{error.code, std::string(field), fmt::format("\"{}\" {}", error.where, error.message)};
}

/// A column as it is stored: the bounds become floats, so that no value is turned into a double.
class StoredRange final : public PointCondition {
  public:
    StoredRange(const ParticleColumns& columns, std::size_t column, FloatRange range)
        : columns_(columns), column_(column), range_(range) {}

    void keep(PointRange block, Words words, Scratch&) const override {
        keepInRange(columns_.values(column_, block.begin, block.count), range_, words);
    }

  private:
    const ParticleColumns& columns_;
    const std::size_t column_;
    const FloatRange range_;
};

/// Reads up to three quantities of a block.
std::array<std::span<double>, axesOfPlot> readBlock(const QuantityReader& reader, PointRange block,
                                                    Scratch& scratch) {
    std::array<std::span<double>, axesOfPlot> out;
    for (std::size_t i = 0; i < reader.size(); ++i) {
        scratch.values[i].resize(blockPoints);
        out[i] = std::span(scratch.values[i]).first(static_cast<std::size_t>(block.count));
    }
    reader.read(block.begin, static_cast<std::size_t>(block.count), scratch.reader,
                std::span(out).first(reader.size()));
    return out;
}

/// One or two quantities and what they must be.
template <class Test>
class OfQuantities final : public PointCondition {
  public:
    OfQuantities(QuantityReader reader, Test test) : reader_(std::move(reader)), test_(std::move(test)) {}

    void keep(PointRange block, Words words, Scratch& scratch) const override {
        const auto out = readBlock(reader_, block, scratch);
        const auto& second = out[reader_.size() - 1];
        keepWhere(words, [&](std::size_t i) { return test_(out[0][i], second[i]); });
    }

  private:
    const QuantityReader reader_;
    const Test test_;
};

template <class Test>
std::unique_ptr<const PointCondition> ofQuantities(QuantityReader reader, Test test) {
    return std::make_unique<const OfQuantities<Test>>(std::move(reader), std::move(test));
}

/// Points of some leaves: these ascend in density, and so do all points.
class InPoints final : public PointCondition {
  public:
    explicit InPoints(PointRange range) : range_(range) {}

    void keep(PointRange block, Words words, Scratch&) const override {
        const auto end = range_.begin + range_.count;
        if (range_.begin <= block.begin && end >= block.begin + block.count) return;
        keepWhere(words,
                  [&](std::size_t i) { return block.begin + i >= range_.begin && block.begin + i < end; });
    }

  private:
    const PointRange range_;
};

/// What a lasso surrounds of its plot, layer space.
class LassoSpace {
  public:
    explicit LassoSpace(const Selection::Lasso& lasso)
        : map_(lasso.camera, lasso.aspect, lasso.transform),
          index_(lasso.points),
          clips_(lasso.clip ? halfSpacesOf(*lasso.clip) : HalfSpaces()) {}

    bool contains(const glm::dvec3& place) const {
        const auto seen = map_(place);
        return index_.contains(seen.x, seen.y) && inAll(clips_, place);
    }

  private:
    const PictureMap map_;
    const PolygonIndex index_;
    const HalfSpaces clips_;
};

class InLasso final : public PointCondition {
  public:
    InLasso(const Selection::Lasso& lasso, const ParticleStep& step) : walk_(step), space_(lasso) {}

    void keep(PointRange block, Words words, Scratch&) const override {
        const auto& leaves = walk_.leaves();
        const auto positions = walk_.step().positions(block.begin, block.count);
        auto leaf = walk_.leafOf(block.begin);
        auto cell = walk_.cell(leaf);
        auto end = leaves.pointBegin[leaf] + leaves.pointCount[leaf];
        keepWhere(words, [&](std::size_t i) {
            for (; block.begin + i >= end; end = leaves.pointBegin[leaf] + leaves.pointCount[leaf])
                cell = walk_.cell(++leaf);
            return space_.contains(cell.at(positions[i]));
        });
    }

  private:
    const LeafWalk walk_;
    const LassoSpace space_;
};

/// A lasso that says its plot: particles are placed by the quantities of its axes.
class InPlotOfLasso final : public PointCondition {
  public:
    InPlotOfLasso(const Selection::Lasso& lasso, QuantityReader reader)
        : reader_(std::move(reader)), plot_(lasso.plot), space_(lasso) {}

    void keep(PointRange block, Words words, Scratch& scratch) const override {
        const auto out = readBlock(reader_, block, scratch);
        keepWhere(words, [&](std::size_t i) {
            glm::dvec3 place(0.0);
            for (std::size_t axis = 0; axis < plot_.size(); ++axis) {
                const auto& [column, min, max] = plot_[axis];
                const double at = (out[axis][i] - min) / (max - min);
                // The plot shows nothing beyond; its outermost particles are held in floats. No number is
                // NaN.
                if (!(at >= -rounding && at <= 1.0 + rounding)) return false;
                place[static_cast<int>(axis)] = 2.0 * at - 1.0;
            }
            return space_.contains(place);
        });
    }

  private:
    static constexpr double rounding = 1e-6;  // of the plot's edge

    const QuantityReader reader_;
    const std::vector<Selection::PlotAxis> plot_;
    const LassoSpace space_;
};

class InMask final : public PointCondition {
  public:
    explicit InMask(PointMask mask) : mask_(std::move(mask)) {}

    void keep(PointRange block, Words words, Scratch&) const override {
        const auto* const own = mask_.words().data() + block.begin / PointMask::wordBits;
        for (std::size_t i = 0; i < words.size(); ++i) words[i] &= own[i];
    }

  private:
    const PointMask mask_;
};

class NoPoints final : public PointCondition {
  public:
    void keep(PointRange, Words words, Scratch&) const override { std::ranges::fill(words, 0); }
};

class AllOf final : public PointCondition {
  public:
    explicit AllOf(PointConditions parts) : parts_(std::move(parts)) {}

    void keep(PointRange block, Words words, Scratch& scratch) const override {
        for (const auto& part : parts_) {
            if (!anyChosen(words)) return;
            part->keep(block, words, scratch);
        }
    }

  private:
    const PointConditions parts_;
};

class AnyOf final : public PointCondition {
  public:
    explicit AnyOf(PointConditions parts) : parts_(std::move(parts)) {}

    void keep(PointRange block, Words words, Scratch& scratch) const override {
        BlockWords left, own;  // those that none has kept so far, and what one keeps of them
        const auto size = words.size();
        std::copy_n(words.begin(), size, left.begin());
        for (const auto& part : parts_) {
            own = left;
            if (!anyChosen(std::span(left).first(size))) break;
            part->keep(block, std::span(own).first(size), scratch);
            for (std::size_t i = 0; i < size; ++i) left[i] &= ~own[i];
        }
        for (std::size_t i = 0; i < size; ++i) words[i] &= ~left[i];
    }

  private:
    const PointConditions parts_;
};

class NoneOf final : public PointCondition {
  public:
    explicit NoneOf(std::unique_ptr<const PointCondition> part) : part_(std::move(part)) {}

    void keep(PointRange block, Words words, Scratch& scratch) const override {
        BlockWords own;
        std::copy(words.begin(), words.end(), own.begin());
        part_->keep(block, std::span(own).first(words.size()), scratch);
        for (std::size_t i = 0; i < words.size(); ++i) words[i] &= ~own[i];
    }

  private:
    const std::unique_ptr<const PointCondition> part_;
};

/// Columns must be there for those that name some. Errors: notFound, at the field.
MadeCondition rangeCondition(const Selection::Range& range, const StepNumbers& step) {
    MOTE_ASSIGN_OR_RETURN(auto reader, readerOf(step, std::span(&range.column, 1), "column"));
    const auto column = step.columns->find(range.column);
    if (column && !step.columns->columns()[*column].doubles) {
        const auto bounds = floatRange(step.columns->columns()[*column].offset, range.min, range.max);
        return MadeCondition(std::make_unique<const StoredRange>(*step.columns, *column, bounds));
    }
    return ofQuantities(std::move(reader), [low = range.min, high = range.max](double value, double) {
        return value >= low && value <= high;
    });
}

MadeCondition polygonCondition(const Selection::Polygon& polygon, const StepNumbers& step) {
    const std::array names{polygon.first, polygon.second};
    MOTE_ASSIGN_OR_RETURN(auto reader, readerOf(step, names, "columns"));
    return ofQuantities(std::move(reader), [index = PolygonIndex(polygon.points)](double x, double y) {
        return index.contains(x, y);
    });
}

MadeCondition outermostCondition(char plane, const OutermostTest& test, const StepNumbers& step) {
    MOTE_ASSIGN_OR_RETURN(auto reader, readerOf(step, planeColumns(plane), "plane"));
    return ofQuantities(std::move(reader), test);
}

/// Throws StorageError.
std::unique_ptr<const PointCondition> densityCondition(const Selection::Density& density,
                                                       const ParticleStep& step) {
    const auto leaves = step.leaves();
    const auto scale = step.logDensity();
    const auto first = std::partition_point(leaves.density.begin(), leaves.density.end(),
                                            [&](float leaf) { return scale.ofLeaf(leaf) < density.min; });
    const auto last = std::partition_point(first, leaves.density.end(),
                                           [&](float leaf) { return scale.ofLeaf(leaf) <= density.max; });
    const auto beginOf = [&](auto leaf) {
        return leaf == leaves.density.end()
                   ? step.pointCount()
                   : leaves.pointBegin[static_cast<std::size_t>(leaf - leaves.density.begin())];
    };
    return std::make_unique<const InPoints>(PointRange{beginOf(first), beginOf(last) - beginOf(first)});
}

/// Of a lasso that says its plot.
MadeCondition lassoByColumns(const Selection::Lasso& lasso, const StepNumbers& step) {
    std::array<std::string, axesOfPlot> names;
    std::ranges::transform(lasso.plot, names.begin(), &Selection::PlotAxis::column);
    MOTE_ASSIGN_OR_RETURN(auto reader, readerOf(step, names, "axes"));
    return MadeCondition(std::make_unique<const InPlotOfLasso>(lasso, std::move(reader)));
}

std::unique_ptr<const PointCondition> lassoCondition(const Selection::Lasso& lasso,
                                                     const ParticleStep& step) {
    return std::make_unique<const InLasso>(lasso, step);
}

std::unique_ptr<const PointCondition> maskCondition(PointMask mask) {
    return std::make_unique<const InMask>(std::move(mask));
}

/// That no point meets.
std::unique_ptr<const PointCondition> noPoints() {
    return std::make_unique<const NoPoints>();
}

std::unique_ptr<const PointCondition> allOf(PointConditions parts) {
    if (parts.size() == 1) return std::move(parts.front());
    return std::make_unique<const AllOf>(std::move(parts));
}

std::unique_ptr<const PointCondition> anyOf(PointConditions parts) {
    return std::make_unique<const AnyOf>(std::move(parts));
}

std::unique_ptr<const PointCondition> noneOf(std::unique_ptr<const PointCondition> part) {
    return std::make_unique<const NoneOf>(std::move(part));
}

class Selector {
  public:
    Selector(const RunSteps& run, const std::function<bool()>& cancelled)
        : run_(run), cancelled_(cancelled) {}

    Result<PointMask> select(const Selection& selection, std::uint32_t step) {
        MOTE_ASSIGN_OR_RETURN(const auto condition, make(selection, step));
        const auto& points = *numbers_.at(step).points;
        PointMask mask(points.pointCount());
        tbb::enumerable_thread_specific<PointCondition::Scratch> scratch;
        const bool whole = forBlocks(blockCount(mask.size()), cancelled_, [&](std::uint64_t block) {
            const auto part = pointsOfBlock(block, mask.size());
            const auto words =
                std::span(mask.words()).subspan(part.begin / PointMask::wordBits, wordCount(part.count));
            std::ranges::fill(words, ~std::uint64_t{0});
            if (const auto over = part.count % PointMask::wordBits; over != 0)
                words.back() = (std::uint64_t{1} << over) - 1;
            condition->keep(part, words, scratch.local());
        });
        if (!whole) return wasCancelled();
        points.check();
        if (const auto& columns = numbers_.at(step).columns) columns->check();
        return mask;
    }

  private:
    /// Kept as long as the conditions that read it.
    Result<const StepNumbers*> numbers(std::uint32_t step) {
        const auto found = numbers_.find(step);
        if (found != numbers_.end()) return &found->second;
        if (const auto steps = run_.manifest().steps_size(); step >= static_cast<std::uint32_t>(steps))
            return Error{ErrorCode::notFound, "step",
                         fmt::format("the run has {} steps, so none with index {}", steps, step)};
        MOTE_ASSIGN_OR_RETURN(auto opened, run_.step(step));
        return &numbers_.emplace(step, std::move(opened)).first->second;
    }

    /// Errors where the step has no columns, or no ids where they are asked for.
    static Status needColumns(const StepNumbers& step, bool ids) {
        if (step.columns && (!ids || step.columns->hasIds())) return success();
        return step.columns ? withoutIds("") : withoutColumns("");
    }

    MadeCondition make(const Selection& selection, std::uint32_t step) {
        if (selection.step && *selection.step != step) return sameIds(selection, *selection.step, step);
        MOTE_ASSIGN_OR_RETURN(const auto* const numbers, this->numbers(step));
        PointConditions parts;
        MOTE_RETURN_IF_ERROR(addOwn(selection, *numbers, parts));
        for (std::size_t i = 0; i < selection.all.size(); ++i) {
            auto part = make(selection.all[i], step);
            MOTE_RETURN_IF_ERROR(part, fmt::format("all[{}]", i));
            parts.push_back(*std::move(part));
        }
        PointConditions any;
        for (std::size_t i = 0; i < selection.any.size(); ++i) {
            auto part = make(selection.any[i], step);
            MOTE_RETURN_IF_ERROR(part, fmt::format("any[{}]", i));
            any.push_back(*std::move(part));
        }
        if (!any.empty()) parts.push_back(anyOf(std::move(any)));
        for (const auto& inner : selection.negated) {
            auto part = make(inner, step);
            MOTE_RETURN_IF_ERROR(part, "not");
            parts.push_back(noneOf(*std::move(part)));
        }
        return allOf(std::move(parts));
    }

    /// The conditions of the selection itself, those first that cost least.
    Status addOwn(const Selection& selection, const StepNumbers& step, PointConditions& parts) {
        if (selection.nothing) parts.push_back(noPoints());
        if (selection.density) parts.push_back(densityCondition(*selection.density, *step.points));
        const auto add = [&](MadeCondition made) -> Status {
            MOTE_RETURN_IF_ERROR(made);
            parts.push_back(*std::move(made));
            return success();
        };
        if (!selection.ids.empty()) MOTE_RETURN_IF_ERROR(add(ofIds(selection, step)), "ids");
        for (std::size_t i = 0; i < selection.ranges.size(); ++i) {
            const auto field = fmt::format("ranges[{}]", i);
            MOTE_RETURN_IF_ERROR(needColumns(step, false), field);
            MOTE_RETURN_IF_ERROR(add(rangeCondition(selection.ranges[i], step)), field);
        }
        if (selection.polygon) {
            MOTE_RETURN_IF_ERROR(needColumns(step, false), "polygon");
            MOTE_RETURN_IF_ERROR(add(polygonCondition(*selection.polygon, step)), "polygon");
        }
        if (selection.outermost)
            MOTE_RETURN_IF_ERROR(add(outermost(*selection.outermost, step)), "outermost");
        if (selection.lasso && !selection.lasso->plot.empty()) {
            MOTE_RETURN_IF_ERROR(needColumns(step, false), "lasso");
            MOTE_RETURN_IF_ERROR(add(lassoByColumns(*selection.lasso, step)), "lasso");
        } else if (selection.lasso && step.points->pointCount() > 0) {
            parts.push_back(lassoCondition(*selection.lasso, *step.points));
        }
        return success();
    }

    MadeCondition outermost(const Selection::Outermost& wanted, const StepNumbers& step) const {
        MOTE_RETURN_IF_ERROR(needColumns(step, false));
        const auto test = findOutermost(wanted, step, cancelled_);
        if (!test.ok() && test.error().code == ErrorCode::notFound) {
            const auto& error = test.error();  // at a column's name
            return Error{error.code, "plane", fmt::format("\"{}\" {}", error.where, error.message)};
        }
        MOTE_RETURN_IF_ERROR(test);
        return outermostCondition(wanted.plane, *test, step);
    }

    MadeCondition ofIds(const Selection& selection, const StepNumbers& step) const {
        MOTE_RETURN_IF_ERROR(needColumns(step, true));
        return inMask(pointsOf(IdSet(selection.ids), *step.columns, cancelled_));
    }

    /// Of a selection that was made in another step.
    MadeCondition sameIds(const Selection& selection, std::uint32_t made, std::uint32_t step) {
        for (const auto one : {made, step}) {
            MOTE_ASSIGN_OR_RETURN(const auto* const numbers, this->numbers(one));
            MOTE_RETURN_IF_ERROR(needColumns(*numbers, true), "step");
        }
        MOTE_ASSIGN_OR_RETURN(const auto mask, select(selection, made));
        const auto ids = IdSet::of(mask, *numbers_.at(made).columns, cancelled_);
        if (!ids) return wasCancelled();
        return inMask(pointsOf(*ids, *numbers_.at(step).columns, cancelled_));
    }

    static MadeCondition inMask(std::optional<PointMask> mask) {
        if (!mask) return wasCancelled();
        return maskCondition(*std::move(mask));
    }

    const RunSteps& run_;
    const std::function<bool()>& cancelled_;
    std::map<std::uint32_t, StepNumbers> numbers_;
};

}  // namespace

Result<PointMask> selectPoints(const Selection& selection, const RunSteps& run, std::uint32_t step,
                               const std::function<bool()>& cancelled) {
    try {
        return Selector(run, cancelled).select(selection, step);
    } catch (const StorageError& error) {
        return error.error();
    }
}

}  // namespace mote::storage
