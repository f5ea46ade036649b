// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/stroke_fragments.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <new>
#include <tuple>
#include <utility>

#include "server/render/plan/in_turns.h"
#include "server/render/plan/stroke_bands.h"

namespace mote::render {
namespace {

/// Fragments of a list at most: 2 GB.
constexpr std::size_t mostFragments = std::size_t{1} << 26;
/// Lines through a row of pixels along which areas are told (docs/PICTURE.md).
constexpr std::uint32_t rowLines = 16;

/// What a wide line covers of a pixel, its middle that far from a place of half that width.
float coverage(double distance, double half) {
    return static_cast<float>(
        std::min(std::min(half, distance + 0.5) - std::max(-half, distance - 0.5), 1.0));
}

double heldToUnit(double share) {
    return std::min(1.0, std::max(0.0, share));
}

/// A part of a line, from a point to the next.
struct Segment {
    double x, y, half, depth;           ///< where it begins, half its width there
    double right, down, wider, deeper;  ///< how much all this changes until it ends
    double perDown = 0.0;               ///< of a level one: 0
    double perLength2;                  ///< of a segment without length: 0, as if it only began

    Segment(const StrokePoint& from, const StrokePoint& to)
        : x(from.x),
          y(from.y),
          half(0.5 * from.width),
          depth(from.depth),
          right(to.x - x),
          down(to.y - y),
          wider(0.5 * to.width - half),
          deeper(to.depth - depth) {
        if (std::abs(down) > 1e-9) perDown = 1.0 / down;
        const double length2 = right * right + down * down;
        perLength2 = length2 > 0.0 ? 1.0 / length2 : 0.0;
    }
};

constexpr double unseen = std::numeric_limits<double>::infinity();

/// Draws a band of rows; of one thread, which draws many.
class BandPainter {
  public:
    BandPainter(const Strokes& strokes, std::uint32_t width, double nearDepth)
        : strokes_(strokes),
          width_(width),
          nearDepth_(nearDepth),
          nearest_(std::size_t{StrokeBands::rows} * width),
          shares_(std::size_t{StrokeBands::rows} * width) {}

    void begin(std::uint32_t top, std::uint32_t bottom) {
        top_ = top;
        bottom_ = bottom;
        fragments_.clear();
    }
    void drawLine(const Stroke& line, double reach);
    void drawArea(const InkArea& area);
    const Fragments& fragments() const { return fragments_; }

  private:
    /// The place of a line that is nearest to a pixel's middle.
    struct Nearest {
        double distance2 = unseen;       ///< squared pixels
        double half = 0.0, depth = 0.0;  ///< half the line's width
    };
    /// A pixel of the band.
    struct Cell {
        std::uint32_t column, row;  ///< from the band's first on
    };
    struct RowSpan {
        std::uint32_t row;
        PixelSpan columns;
    };
    struct Crossing {
        std::uint32_t line;  ///< from the band's first on
        double x;
        auto operator<=>(const Crossing&) const = default;
    };

    void approach(const StrokePoint& from, const StrokePoint& to, double reach);
    void approachRow(std::uint32_t row, PixelSpan columns, const Segment& segment);
    void cross(const StrokePoint& from, const StrokePoint& to);
    void addSpan(std::uint32_t row, double left, double right);
    void add(Cell cell, double depth, float opacity) {
        if (opacity > 0.0F && depth >= nearDepth_)
            fragments_.push_back({cell.column, top_ + cell.row, depth, opacity, strokes_.color});
    }
    void addShare(Cell cell, double share) {
        const float depth = strokes_.areaDepths.at(cell.column, top_ + cell.row);
        if (std::isfinite(depth))
            add(cell, static_cast<double>(depth), static_cast<float>(std::min(share, 1.0)));
    }
    std::size_t indexOf(Cell cell) const { return std::size_t{cell.row} * width_ + cell.column; }

    const Strokes& strokes_;
    const std::uint32_t width_;
    const double nearDepth_;
    std::uint32_t top_ = 0, bottom_ = 0;
    std::vector<Nearest> nearest_;  // of the band's pixels, row by row
    std::vector<RowSpan> spans_;    // where a line may be near; a pixel may be in several
    std::vector<double> shares_;    // of the band's pixels that an area covers
    std::vector<Crossing> crossings_;
    Fragments fragments_;
};

void BandPainter::drawLine(const Stroke& line, double reach) {
    const StrokePoint* const points = strokes_.points.data();
    if (line.end - line.begin == 1) approach(points[line.begin], points[line.begin], reach);
    for (auto i = line.begin; i + 1 < line.end; ++i) approach(points[i], points[i + 1], reach);
    for (const auto& [row, columns] : spans_) {
        for (auto column = columns.begin; column < columns.end; ++column) {
            Nearest& place = nearest_[indexOf({column, row})];
            if (place.distance2 < reach * reach)
                add({column, row}, place.depth, coverage(std::sqrt(place.distance2), place.half));
            place.distance2 = unseen;
        }
    }
    spans_.clear();
}

/// Only the part of a segment that is within reach of a row, up and down, can be so of a pixel in it.
void BandPainter::approach(const StrokePoint& from, const StrokePoint& to, double reach) {
    const Segment segment(from, to);
    const auto [low, high] = std::minmax({from.y, to.y});
    const PixelSpan rows = pixelsBetween(low - reach, high + reach, bottom_);
    for (auto row = std::max(rows.begin, top_); row < rows.end; ++row) {
        double first = 0.0, last = 1.0;
        if (segment.perDown != 0.0) {
            const double middle = (row + 0.5 - segment.y) * segment.perDown;
            const double around = reach * std::abs(segment.perDown);
            first = heldToUnit(middle - around);
            last = heldToUnit(middle + around);
        }
        const double begin = segment.x + first * segment.right, end = segment.x + last * segment.right;
        approachRow(row - top_,
                    pixelsBetween(std::min(begin, end) - reach, std::max(begin, end) + reach, width_),
                    segment);
    }
}

/// Without branches, which could not be foretold.
void BandPainter::approachRow(std::uint32_t row, PixelSpan columns, const Segment& segment) {
    if (columns.empty()) return;
    spans_.push_back({row, columns});
    Nearest* const cells = nearest_.data() + std::size_t{row} * width_;
    const double y = top_ + row + 0.5 - segment.y, yAlong = y * segment.down;
    for (auto column = columns.begin; column < columns.end; ++column) {
        const double x = column + 0.5 - segment.x;
        const double share = heldToUnit((x * segment.right + yAlong) * segment.perLength2);
        const double acrossX = x - share * segment.right, acrossY = y - share * segment.down;
        const double distance2 = acrossX * acrossX + acrossY * acrossY;
        Nearest& nearest = cells[column];
        const bool nearer = distance2 < nearest.distance2;
        nearest.half = nearer ? segment.half + share * segment.wider : nearest.half;
        nearest.depth = nearer ? segment.depth + share * segment.deeper : nearest.depth;
        nearest.distance2 = nearer ? distance2 : nearest.distance2;
    }
}

void BandPainter::drawArea(const InkArea& area) {
    crossings_.clear();
    for (auto i = area.begin; i < area.end; ++i) {
        const auto [begin, end] = strokes_.outlines[i];
        for (auto j = begin; j < end; ++j)
            cross(strokes_.points[j], strokes_.points[j + 1 < end ? j + 1 : begin]);
    }
    if (crossings_.empty()) return;
    std::sort(crossings_.begin(), crossings_.end());
    double left = width_, right = 0.0;
    // Each line is crossed an even number of times.
    for (std::size_t i = 0; i + 1 < crossings_.size(); i += 2) {
        const double from = std::clamp<double>(crossings_[i].x, 0.0, width_);
        const double to = std::clamp<double>(crossings_[i + 1].x, 0.0, width_);
        addSpan(crossings_[i].line / rowLines, from, to);
        left = std::min(left, from);
        right = std::max(right, to);
    }
    const auto end = static_cast<std::uint32_t>(std::ceil(right));
    for (auto row = crossings_.front().line / rowLines; row <= crossings_.back().line / rowLines; ++row) {
        for (auto column = static_cast<std::uint32_t>(left); column < end; ++column) {
            double& share = shares_[indexOf({column, row})];
            if (share > 0.0) addShare({column, row}, share);
            share = 0.0;
        }
    }
}

/// A line belongs to an edge that begins on it and not to one that ends there, so that it is crossed once
/// where two edges meet.
void BandPainter::cross(const StrokePoint& from, const StrokePoint& to) {
    const auto [low, high] = std::minmax({from.y, to.y});
    const auto firstLine = [&](double y) {
        const double line = std::ceil((y - top_) * rowLines - 0.5);
        return static_cast<std::uint32_t>(std::clamp<double>(line, 0.0, (bottom_ - top_) * rowLines));
    };
    const double slope = (double{to.x} - from.x) / (double{to.y} - from.y);
    for (auto line = firstLine(low), end = firstLine(high); line < end; ++line)
        crossings_.push_back({line, from.x + (top_ + (line + 0.5) / rowLines - from.y) * slope});
}

void BandPainter::addSpan(std::uint32_t row, double left, double right) {
    if (!(left < right)) return;
    double* const shares = shares_.data() + std::size_t{row} * width_;
    const auto first = static_cast<std::uint32_t>(left), last = static_cast<std::uint32_t>(right);
    if (first == last) {
        shares[first] += (right - left) / rowLines;
        return;
    }
    shares[first] += (first + 1 - left) / rowLines;
    for (auto column = first + 1; column < last; ++column) shares[column] += 1.0 / rowLines;
    if (last < width_) shares[last] += (right - last) / rowLines;
}

/// Of all that the strokes hide together in a pixel, front to back, the share `opacity`, below 1: what each
/// then hides of what those before it leave.
void fade(Fragments& fragments, double opacity) {
    const auto pixel = [](const Fragment& one) { return std::pair(one.row, one.column); };
    std::stable_sort(fragments.begin(), fragments.end(), [&](const Fragment& a, const Fragment& b) {
        return std::tuple(pixel(a), a.depth) < std::tuple(pixel(b), b.depth);
    });
    double left = 1.0;  // of the light, were they not faded
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        if (i > 0 && pixel(fragments[i]) != pixel(fragments[i - 1])) left = 1.0;
        const double lost = left * fragments[i].opacity;
        fragments[i].opacity = static_cast<float>(opacity * lost / (1.0 - opacity * (1.0 - left)));
        left -= lost;
    }
    std::erase_if(fragments, [](const Fragment& one) { return !(one.opacity > 0.0F); });
}

}  // namespace

std::vector<Fragments> strokeFragments(const Strokes& strokes, std::uint32_t width, std::uint32_t height,
                                       double nearDepth) {
    const StrokeBands bands(strokes, width, height);
    const auto lines = static_cast<std::uint32_t>(strokes.lines.size());
    std::vector<Fragments> parts(bands.count());
    std::atomic<std::size_t> count{0};
    tbb::enumerable_thread_specific<BandPainter> painters(
        [&] { return BandPainter(strokes, width, nearDepth); });
    forInTurns(0U, bands.count(), [&](std::uint32_t i) {
        if (bands.of(i).empty()) return;
        BandPainter& painter = painters.local();
        painter.begin(i * StrokeBands::rows, std::min((i + 1) * StrokeBands::rows, height));
        for (const auto item : bands.of(i)) {
            item < lines ? painter.drawLine(strokes.lines[item], bands.reach(item))
                         : painter.drawArea(strokes.areas[item - lines]);
            if (count + painter.fragments().size() > mostFragments) throw std::bad_alloc();
        }
        parts[i] = painter.fragments();
        if (strokes.opacity < 1.0F) fade(parts[i], static_cast<double>(strokes.opacity));
        count += parts[i].size();
    });
    return parts;
}

}  // namespace mote::render
