// SPDX-License-Identifier: GPL-3.0-or-later
//
// FieldPieces cuts a ray through a grid field where it goes from one cell into the next. Within a cell the
// trilinear codes are a cubic polynomial of the way, so what the ray meets of them is found exactly, however
// thin it is. Refers to the field; any number of threads.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "server/render/plan/grid_field.h"

namespace mote::render {

/// A line, by depth.
struct DepthLine {
    glm::dvec3 origin{0.0}, perDepth{0.0};

    glm::dvec3 at(double depth) const { return origin + depth * perDepth; }
};

/// The cells of a grid along a line, told in them, between two depths; the outermost ones have no end.
class LineCells {
  public:
    LineCells(const DepthLine& line, const glm::ivec3& first, const glm::ivec3& last, double from, double to)
        : line_(line), first_(first), last_(last), from_(from), to_(to) {
        cell_ = glm::ivec3(glm::floor(glm::clamp(line.at(from), glm::dvec3(first), glm::dvec3(last))));
        for (int axis = 0; axis < 3; ++axis) ends_[axis] = endOf(axis);
    }

    const glm::ivec3& cell() const { return cell_; }
    double from() const { return from_; }
    double to() const { return std::clamp(ends_[axis()], from_, to_); }
    /// To the next one; false where there is none.
    bool next() {
        const int crossed = axis();
        if (!(ends_[crossed] < to_)) return false;
        from_ = std::max(from_, ends_[crossed]);
        cell_[crossed] += line_.perDepth[crossed] > 0.0 ? 1 : -1;
        ends_[crossed] = endOf(crossed);
        return true;
    }

  private:
    int axis() const {
        const int one = ends_.x <= ends_.y ? 0 : 1;
        return ends_[one] <= ends_.z ? one : 2;
    }
    double endOf(int axis) const {
        const double speed = line_.perDepth[axis];
        if (speed == 0.0 || cell_[axis] == (speed > 0.0 ? last_ : first_)[axis])
            return std::numeric_limits<double>::infinity();
        return (cell_[axis] + (speed > 0.0 ? 1 : 0) - line_.origin[axis]) / speed;
    }

    DepthLine line_;
    glm::ivec3 first_, last_, cell_;
    double from_, to_;
    glm::dvec3 ends_;  // depths at which it leaves the cell along each axis
};

/// The codes of a ray within a cell, by the share x of its way there, 0 to 1.
class CodePiece {
  public:
    /// `codes`: of the cell's corners, x fastest. `from`, `to`: shares of the way between them.
    CodePiece(const std::array<double, 8>& codes, const glm::dvec3& from, const glm::dvec3& to) {
        const double a = between(codes, from), d = between(codes, to);
        const double b = between(codes, glm::mix(from, to, 1.0 / 3.0));
        const double c = between(codes, glm::mix(from, to, 2.0 / 3.0));
        terms_ = {a, 0.5 * (18.0 * b - 11.0 * a - 9.0 * c + 2.0 * d), 4.5 * (2.0 * a - 5.0 * b + 4.0 * c - d),
                  4.5 * (d - a + 3.0 * (b - c))};
        std::size_t count = 0;
        for (const double x : turns())
            if (x > 0.0 && x < 1.0) stops_[count++] = x;
    }

    double at(double x) const { return ((terms_[3] * x + terms_[2]) * x + terms_[1]) * x + terms_[0]; }
    /// In order: between them, and 0 and 1, it ascends or descends.
    const std::array<double, 3>& stops() const { return stops_; }
    /// The first place with such a code at least.
    std::optional<double> first(double code) const {
        if (at(0.0) >= code) return 0.0;
        double before = 0.0;
        for (double place : stops_) {
            if (at(place) >= code) {
                for (int halving = 0; halving < 32; ++halving) {
                    const double middle = 0.5 * (before + place);
                    (at(middle) >= code ? place : before) = middle;
                }
                return place;
            }
            before = place;
        }
        return std::nullopt;
    }

  private:
    static double between(const std::array<double, 8>& codes, const glm::dvec3& share) {
        std::array<double, 4> rows{};
        for (std::size_t i = 0; i < 4; ++i)
            rows[i] = codes[2 * i] + share.x * (codes[2 * i + 1] - codes[2 * i]);
        const double near = rows[0] + share.y * (rows[1] - rows[0]);
        return near + share.z * (rows[2] + share.y * (rows[3] - rows[2]) - near);
    }
    /// Where it turns from ascent to descent or back, in order; 2 for what there is not.
    std::array<double, 2> turns() const {
        const double a = 3.0 * terms_[3], b = terms_[2], c = terms_[1];  // a x^2 + 2 b x + c
        const double square = b * b - a * c;
        if (!(square > 0.0)) return {2.0, 2.0};
        const double q = -(b + std::copysign(std::sqrt(square), b));
        const double one = a != 0.0 ? q / a : 2.0, other = q != 0.0 ? c / q : 2.0;
        return {std::min(one, other), std::max(one, other)};
    }

    std::array<double, 4> terms_;
    std::array<double, 3> stops_{1.0, 1.0, 1.0};
};

class FieldPieces {
  public:
    /// `corrected`: whether the field's bricks are, where there are some.
    FieldPieces(const GridField& field, bool corrected)
        : coarse_(field.coarse),
          bricks_(corrected ? field.bricks.get() : nullptr),
          cells_(bricks_ != nullptr ? bricks_->size : coarse_.size),
          blocks_((cells_ + edge - 1) / edge) {}

    /// Calls visitor.take(piece, depth where it begins, where it ends) for one after another while it returns
    /// true; only in blocks, of 8 x 8 x 8 cells, of which visitor.enters(block) is, and in cells of whose
    /// greatest code visitor.wants(code) is. `line`: in cells of the finest grid from the box's corner.
    template <class Visitor>
    void along(const DepthLine& line, double from, double to, Visitor& visitor) const {
        const DepthLine inBlocks{(line.origin - 0.5) / double{edge}, line.perDepth / double{edge}};
        LineCells blocks(inBlocks, glm::ivec3(0), blocks_ - 1, from, to);
        do {
            const glm::ivec3 block = blocks.cell();
            const auto index =
                static_cast<std::size_t>((std::int64_t{block.z} * blocks_.y + block.y) * blocks_.x + block.x);
            if (visitor.enters(index) && !within(gridOf(block, index), line, blocks, visitor)) return;
        } while (blocks.next());
    }

  private:
    static constexpr int edge = GridBricks::edge;

    /// The cells of a block: those of its brick, or of the coarse grid. Cell k lies before sample k.
    struct Grid {
        const std::uint16_t* values;
        glm::ivec3 corner, last;  ///< the sample that comes first in memory, the last of the whole grid
        std::int64_t row, sheet;  ///< in memory
        glm::ivec3 firstCell, lastCell;
        glm::dvec3 scale;  ///< cells a cell of the finest grid

        std::array<double, 8> corners(const glm::ivec3& cell) const {
            const glm::ivec3 low = glm::clamp(cell - 1, glm::ivec3(0), last) - corner;
            const glm::ivec3 high = glm::min(cell, last) - corner;
            std::array<double, 8> codes{};
            for (std::size_t i = 0; i < 4; ++i) {
                const std::uint16_t* const begin =
                    values + (i >> 1U ? high : low).z * sheet + (i & 1U ? high : low).y * row;
                codes[2 * i] = begin[low.x];
                codes[2 * i + 1] = begin[high.x];
            }
            return codes;
        }
    };
    Grid gridOf(const glm::ivec3& block, std::size_t index) const {
        const std::int32_t brick = bricks_ != nullptr ? bricks_->numbers[index] : GridBricks::none;
        if (brick == GridBricks::none) {
            const glm::ivec3 size(coarse_.size);
            return {coarse_.values.data(),
                    glm::ivec3(0),
                    size - 1,
                    size.x,
                    std::int64_t{size.x} * size.y,
                    glm::ivec3(0),
                    size,
                    glm::dvec3(size) / glm::dvec3(cells_)};
        }
        const glm::ivec3 corner = block * edge, end = glm::min(corner + edge, cells_);
        constexpr std::int64_t samples = GridBricks::samples;
        Grid grid{bricks_->values.data() + static_cast<std::size_t>(brick) * GridBricks::volume,
                  corner,
                  cells_ - 1,
                  samples,
                  samples * samples,
                  corner + 1,
                  end,
                  glm::dvec3(1.0)};
        // The outermost blocks reach to the box's sides.
        for (int axis = 0; axis < 3; ++axis) {
            if (block[axis] == 0) grid.firstCell[axis] = 0;
            if (block[axis] + 1 == blocks_[axis]) grid.lastCell[axis] = cells_[axis];
        }
        return grid;
    }
    template <class Visitor>
    static bool within(const Grid& grid, const DepthLine& line, const LineCells& block, Visitor& visitor) {
        const DepthLine inCells{line.origin * grid.scale + 0.5, line.perDepth * grid.scale};
        LineCells cells(inCells, grid.firstCell, grid.lastCell, block.from(), block.to());
        do {
            const auto codes = grid.corners(cells.cell());
            if (!visitor.wants(*std::max_element(codes.begin(), codes.end()))) continue;
            const glm::dvec3 cell(cells.cell());
            const CodePiece piece(codes, inCells.at(cells.from()) - cell, inCells.at(cells.to()) - cell);
            if (!visitor.take(piece, cells.from(), cells.to())) return false;
        } while (cells.next());
        return true;
    }

    const SampleGrid& coarse_;
    const GridBricks* bricks_;  // null: the coarse grid is the finest
    glm::ivec3 cells_, blocks_;
};

}  // namespace mote::render
