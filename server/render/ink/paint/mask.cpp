// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/paint/mask.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

/// Connected pixels, by their sides, of one value that are fewer than some get the other one.
void dropSmall(Raster<std::uint8_t>& mask, std::uint8_t value, std::size_t least,
               const std::stop_token& stop) {
    std::vector<std::uint8_t> seen(mask.values.size());
    std::vector<std::size_t> front;
    const std::size_t width = mask.width;
    const auto take = [&](std::size_t pixel) {
        if (seen[pixel] != 0 || mask.values[pixel] != value) return;
        seen[pixel] = 1;
        front.push_back(pixel);
    };
    for (std::size_t seed = 0; seed < mask.values.size(); ++seed) {
        if (seed % width == 0 && isStopped(stop)) return;
        front.clear();
        take(seed);
        for (std::size_t next = 0; next < front.size(); ++next) {
            const std::size_t pixel = front[next], column = pixel % width;
            if (column > 0) take(pixel - 1);
            if (column + 1 < width) take(pixel + 1);
            if (pixel >= width) take(pixel - width);
            if (pixel + width < mask.values.size()) take(pixel + width);
        }
        if (front.size() >= least) continue;
        for (const auto pixel : front) mask.values[pixel] = value == 0 ? 1 : 0;
    }
}

constexpr std::size_t columnsATime = 64;

/// To the nearest mark of the same column.
void alongColumns(const Raster<std::uint8_t>& marks, float most, Raster<float>& made,
                  const tbb::blocked_range<std::size_t>& columns) {
    const std::size_t width = marks.width, height = marks.height;
    for (std::size_t row = 0; row < height; ++row) {
        for (std::size_t i = row * width + columns.begin(); i < row * width + columns.end(); ++i) {
            const float before = row > 0 ? made.values[i - width] + 1.0F : most;
            made.values[i] = marks.values[i] != 0 ? 0.0F : std::min(before, most);
        }
    }
    for (std::size_t row = height; row-- > 1;) {
        for (std::size_t i = row * width + columns.begin(); i < row * width + columns.end(); ++i)
            made.values[i - width] = std::min(made.values[i - width], made.values[i] + 1.0F);
    }
}

/// The lower envelope of parabolas over a row, one around each of its pixels.
class Envelope {
  public:
    void make(float* values, std::size_t width, float most) {
        own_.assign(values, values + width);
        columns_.clear();
        begins_.clear();
        for (std::size_t column = 0; column < width; ++column) {
            if (own_[column] < most) add(column);
        }
        std::size_t at = 0;
        for (std::size_t column = 0; column < width && !columns_.empty(); ++column) {
            while (at + 1 < columns_.size() && begins_[at + 1] < static_cast<double>(column)) ++at;
            values[column] = std::min(most, static_cast<float>(std::sqrt(heightAt(columns_[at], column))));
        }
    }

  private:
    double heightAt(std::size_t of, std::size_t column) const {
        const double away = static_cast<double>(of) - static_cast<double>(column);
        return away * away + squareOf(of);
    }
    double squareOf(std::size_t column) const {
        const auto own = static_cast<double>(own_[column]);
        return own * own;
    }
    void add(std::size_t column) {
        double begin = -1.0;
        while (!columns_.empty()) {
            const auto last = static_cast<double>(columns_.back()), here = static_cast<double>(column);
            begin =
                0.5 * (here + last) + 0.5 * (squareOf(column) - squareOf(columns_.back())) / (here - last);
            if (begin > begins_.back()) break;
            columns_.pop_back();
            begins_.pop_back();
        }
        begins_.push_back(columns_.empty() ? -1.0 : begin);
        columns_.push_back(column);
    }

    std::vector<float> own_;            // the row, before
    std::vector<std::size_t> columns_;  // of parabolas of the envelope
    std::vector<double> begins_;        // where they are lowest from on
};

}  // namespace

void dropSpecksAndHoles(Raster<std::uint8_t>& mask, std::size_t least, const std::stop_token& stop) {
    dropSmall(mask, 1, least, stop);
    dropSmall(mask, 0, least, stop);
}

Raster<float> distanceTo(const Raster<std::uint8_t>& marks, double most, const std::stop_token& stop) {
    const auto farthest = static_cast<float>(most);
    Raster<float> made(marks.width, marks.height, farthest);
    forRangesInTurns(marks.width, columnsATime, [&](const auto& columns) {
        if (!isStopped(stop)) alongColumns(marks, farthest, made, columns);
    });
    constexpr std::size_t rowsATime = 16;
    forRangesInTurns(marks.height, rowsATime, [&](const auto& rows) {
        if (isStopped(stop)) return;
        Envelope envelope;
        for (auto row = rows.begin(); row < rows.end(); ++row)
            envelope.make(made.values.data() + row * made.width, made.width, farthest);
    });
    return made;
}

}  // namespace mote::render
