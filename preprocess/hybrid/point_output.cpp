// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/hybrid/point_output.h"

#include <algorithm>
#include <tuple>

#include "storage/hybrid/hybrid_points.h"

namespace mote::prep {
namespace {

auto orderInFile(const PointPiece& piece) {
    return std::tuple(piece.layer, piece.row, piece.z);
}

/// A row's points as they lie on disk.
class StoredRow {
  public:
    StoredRow(std::uint32_t row, std::uint32_t layer, std::uint32_t bytes)
        : row_(row), layer_(layer), bytes_(bytes) {}

    void add(const PointRow& from, std::size_t i, std::uint32_t brick) {
        constexpr std::uint32_t side = storage::pointBrickSide;
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
