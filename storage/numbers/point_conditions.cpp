// SPDX-License-Identifier: GPL-3.0-or-later
#include "storage/numbers/point_conditions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "storage/numbers/point_places.h"
#include "storage/numbers/polygon_index.h"
#include "storage/numbers/range_kernel.h"
#include "storage/numbers/scan.h"

namespace mote::storage {
namespace {

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

/// One or two quantities and what they must be.
template <class Test>
class OfQuantities final : public PointCondition {
  public:
    OfQuantities(QuantityReader reader, Test test) : reader_(std::move(reader)), test_(std::move(test)) {}

    void keep(PointRange block, Words words, Scratch& scratch) const override {
        const auto count = static_cast<std::size_t>(block.count);
        scratch.first.resize(blockPoints);
        scratch.second.resize(blockPoints);
        const std::array out{std::span(scratch.first).first(count), std::span(scratch.second).first(count)};
        reader_.read(block.begin, count, scratch.reader, std::span(out).first(reader_.size()));
        keepWhere(words, [&](std::size_t i) { return test_(out[0][i], out[1][i]); });
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

class InLasso final : public PointCondition {
  public:
    InLasso(const Selection::Lasso& lasso, const ParticleStep& step)
        : walk_(step), map_(lasso.camera, lasso.aspect, lasso.transform), index_(lasso.points) {}

    void keep(PointRange block, Words words, Scratch&) const override {
        const auto& leaves = walk_.leaves();
        const auto positions = walk_.step().positions(block.begin, block.count);
        auto leaf = walk_.leafOf(block.begin);
        auto cell = walk_.cell(leaf);
        auto end = leaves.pointBegin[leaf] + leaves.pointCount[leaf];
        keepWhere(words, [&](std::size_t i) {
            for (; block.begin + i >= end; end = leaves.pointBegin[leaf] + leaves.pointCount[leaf])
                cell = walk_.cell(++leaf);
            const auto seen = map_(cell.at(positions[i]));
            return index_.contains(seen.x, seen.y);
        });
    }

  private:
    const LeafWalk walk_;
    const PictureMap map_;
    const PolygonIndex index_;
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

}  // namespace

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

std::unique_ptr<const PointCondition> lassoCondition(const Selection::Lasso& lasso,
                                                     const ParticleStep& step) {
    return std::make_unique<const InLasso>(lasso, step);
}

std::unique_ptr<const PointCondition> maskCondition(PointMask mask) {
    return std::make_unique<const InMask>(std::move(mask));
}

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

}  // namespace mote::storage
