// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/point_collector.h"

#include <oneapi/tbb/concurrent_vector.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "preprocess/on_threads.h"

namespace mote::prep {
namespace {

/// Calls visit(array) for each array of a row, those of larger numbers first.
template <class Row, class Visit>
void eachArray(Row& row, const Visit& visit) {
    visit(row.brickCount);
    visit(row.place);
    visit(row.value);
    visit(row.error);
    visit(row.normal);
    visit(row.least);
}

constexpr std::uint32_t side = storage::pointBrickSide;

auto orderInFile(const PointPiece& piece) {
    return std::tuple(piece.layer, piece.row, piece.z);
}

/// A row's points as they lie on disk.
class StoredRow {
  public:
    StoredRow(std::uint32_t row, std::uint32_t layer, std::uint32_t bytes)
        : row_(row), layer_(layer), bytes_(bytes) {}

    void add(const PointRow& from, std::size_t i, std::uint32_t brick) {
        const std::uint32_t place = from.place[i];
        const std::array<std::uint32_t, 3> grid{brick * side + place % side,
                                                row_ * side + place / side % side,
                                                layer_ * side + place / side / side};
        if (bytes_ == 5)
            place16_.push_back(static_cast<std::uint16_t>(place - (brick == brick_ ? before_ : 0)));
        brick_ = brick;
        before_ = place;
        for (const auto coordinate : grid) {
            if (bytes_ == 6) place8_.push_back(static_cast<std::uint8_t>(coordinate));
            if (bytes_ == 9) place16_.push_back(static_cast<std::uint16_t>(coordinate));
        }
        value_.push_back(from.value[i]);
        error_.push_back(from.error[i]);
        normal_.push_back(from.normal[i]);
    }
    std::uint64_t size() const { return value_.size(); }
    storage::HybridPoints view() const {
        storage::HybridPoints points;
        (bytes_ == 5 ? points.advance : points.place16) = place16_;
        points.place8 = place8_;
        points.value = value_;
        points.error = error_;
        points.normal = normal_;
        return points;
    }

  private:
    std::uint32_t row_, layer_, bytes_;
    std::uint32_t brick_ = ~0U, before_ = 0;  ///< of the point before
    std::vector<std::uint8_t> place8_;
    std::vector<std::uint16_t> place16_;
    std::vector<std::uint8_t> value_, error_, normal_;
};

class Output {
  public:
    Output(const PointPieces& points, const storage::GridSize& grid, std::uint32_t bytes,
           const storage::HybridStepWriter& file)
        : points_(points),
          bricks_(storage::bricksOf(grid, storage::pointBrickSide)),
          bytes_(bytes),
          file_(file),
          leastLeft_(points.mostOfLeast) {
        brickBegin_.push_back(0);
    }

    /// The pieces of one row; rows in their order, those without a point left out.
    Status add(std::span<const PointPiece> pieces) {
        const auto& piece = pieces.front();
        std::vector<PointRow> parts;
        for (const auto& part : pieces) {
            MOTE_ASSIGN_OR_RETURN(auto loaded,
                                  PointRow::load(part, bricks_[0], *points_.scratches[part.scratch]));
            parts.push_back(std::move(loaded));
        }
        brickBegin_.resize(std::size_t{bricks_[0]} * (bricks_[1] * piece.layer + piece.row) + 1, written_);
        StoredRow row(piece.row, piece.layer, bytes_);
        std::vector<std::size_t> next(parts.size(), 0);
        for (std::uint32_t brick = 0; brick < bricks_[0]; ++brick) {
            for (std::size_t i = 0; i < parts.size(); ++i) {
                for (const auto end = next[i] + parts[i].brickCount[brick]; next[i] < end; ++next[i]) {
                    if (take(parts[i].least[next[i]] != 0)) row.add(parts[i], next[i], brick);
                }
            }
            brickBegin_.push_back(written_ + row.size());
        }
        MOTE_RETURN_IF_ERROR(file_.writePoints(written_, row.view()));
        written_ += row.size();
        return success();
    }

    Status finish() {
        if (bytes_ != 5) return success();
        brickBegin_.resize(storage::samplesOf(bricks_) + 1, written_);
        return file_.writeBricks(brickBegin_);
    }

  private:
    bool take(bool least) {
        if (!least) return true;
        if (leastLeft_ == 0) return false;
        --leastLeft_;
        return true;
    }

    const PointPieces& points_;
    storage::GridSize bricks_;
    std::uint32_t bytes_;
    const storage::HybridStepWriter& file_;
    std::uint64_t leastLeft_;
    std::uint64_t written_ = 0;
    std::vector<std::uint64_t> brickBegin_;
};

}  // namespace

Result<PointPiece> PointRow::store(storage::ScratchFile& scratch) const {
    std::vector<std::byte> all;
    eachArray(*this, [&](const auto& array) {
        const auto bytes = std::as_bytes(std::span(array));
        all.insert(all.end(), bytes.begin(), bytes.end());
    });
    MOTE_ASSIGN_OR_RETURN(const auto at, scratch.append(all));
    PointPiece piece;
    piece.offset = at;
    piece.points = place.size();
    piece.least = std::accumulate(least.begin(), least.end(), std::uint64_t{0});
    return piece;
}

Result<PointRow> PointRow::load(const PointPiece& piece, std::size_t bricks,
                                const storage::ScratchFile& scratch) {
    PointRow row;
    eachArray(row, [&](auto& array) { array.resize(piece.points); });
    row.brickCount.resize(bricks);
    auto at = piece.offset;
    Status status = success();
    eachArray(row, [&](auto& array) {
        const auto bytes = std::as_writable_bytes(std::span(array));
        if (status.ok()) status = scratch.read(at, bytes);
        at += bytes.size();
    });
    if (!status.ok()) return status.error();
    return row;
}

std::uint8_t PointCoding::valueCode(float value) const {
    if (!(valueSpan > 0.0)) return 0;
    const double code = (value - valueMin) / valueSpan * (storage::pointValueCodes - 1);
    return static_cast<std::uint8_t>(std::clamp(std::floor(code + 0.5), 0.0, 255.0));
}

std::uint8_t PointCoding::errorCode(float error) const {
    if (!(errorStep > 0.0)) return storage::errorCodeZero;
    const double code = std::floor(error / errorStep + 0.5) + storage::errorCodeZero;
    return static_cast<std::uint8_t>(std::clamp(code, 0.0, 255.0));
}

PointCollector::PointCollector(const VolumePlan& plan, const PointCoding& coding,
                               const ErrorSelection& selection, storage::ScratchFile& scratch)
    : plan_(plan),
      bricks_(storage::bricksOf(plan.error, side)),
      coding_(coding),
      selection_(selection),
      scratch_(scratch),
      normals_(plan.error, gridToWorld(plan, plan.error)) {}

Status PointCollector::add(const ErrorSlab& slab) {
    MOTE_CHECK(slab.z0 / side == (slab.z1 - 1) / side);
    FirstError failure;
    tbb::concurrent_vector<PointPiece> pieces;
    tbb::parallel_for(std::uint32_t{0}, bricks_[1], [&](std::uint32_t row) {
        const auto points = collect(row, slab);
        if (points.place.empty()) return;
        auto piece = points.store(scratch_);
        if (!piece.ok()) return failure.set(piece.error());
        piece->layer = slab.z0 / side;
        piece->row = row;
        piece->z = slab.z0;
        pieces.push_back(*piece);
    });
    pieces_.insert(pieces_.end(), pieces.begin(), pieces.end());
    return failure.status();
}

PointRow PointCollector::collect(std::uint32_t row, const ErrorSlab& slab) const {
    PointRow points;
    for (std::uint32_t bx = 0; bx < bricks_[0]; ++bx) {
        points.brickCount.push_back(addBrick(bx, row, slab, points));
    }
    return points;
}

std::uint32_t PointCollector::addBrick(std::uint32_t bx, std::uint32_t by, const ErrorSlab& slab,
                                       PointRow& to) const {
    const auto before = to.place.size();
    const auto right = std::min(plan_.error[0], (bx + 1) * side);
    const auto back = std::min(plan_.error[1], (by + 1) * side);
    for (auto z = slab.z0; z < slab.z1; ++z) {
        const auto values = slab.values(z);
        for (auto y = by * side; y < back; ++y) {
            const auto row = std::size_t{y} * plan_.error[0];
            const auto* errors = slab.error(z) + row;
            for (auto x = bx * side; x < right; ++x) {
                const float error = errors[x];
                if (!selection_.takes(error)) continue;
                to.place.push_back(
                    static_cast<std::uint16_t>(x % side + side * (y % side) + side * side * (z % side)));
                to.value.push_back(coding_.valueCode(values[1][row + x]));
                to.error.push_back(coding_.errorCode(error));
                to.normal.push_back(normals_.code(values, {x, y, z}));
                to.least.push_back(std::abs(error) == selection_.least ? 1 : 0);
            }
        }
    }
    return static_cast<std::uint32_t>(to.place.size() - before);
}

std::uint64_t PointPieces::size() const {
    std::uint64_t all = 0;
    std::uint64_t least = 0;
    for (const auto& piece : pieces) {
        all += piece.points;
        least += piece.least;
    }
    return all - least + std::min(least, mostOfLeast);
}

Status writePoints(PointPieces points, const storage::GridSize& grid, std::uint32_t bytes,
                   const std::function<Status()>& progress, const storage::HybridStepWriter& file) {
    std::sort(points.pieces.begin(), points.pieces.end(),
              [](const auto& a, const auto& b) { return orderInFile(a) < orderInFile(b); });
    Output output(points, grid, bytes, file);
    auto rest = std::span<const PointPiece>(points.pieces);
    while (!rest.empty()) {
        MOTE_RETURN_IF_ERROR(progress());
        std::size_t count = 1;
        while (count < rest.size() && rest[count].layer == rest[0].layer && rest[count].row == rest[0].row) {
            ++count;
        }
        MOTE_RETURN_IF_ERROR(output.add(rest.first(count)));
        rest = rest.subspan(count);
    }
    return output.finish();
}

}  // namespace mote::prep
