// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/plan/stroke_fragments.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <span>
#include <tuple>
#include <utility>

#include "server/render/plan/in_turns.h"

namespace mote::render {
namespace {

constexpr std::size_t linesOfAChunk = 256;

std::uint32_t tilesOfSide(std::uint32_t pixels) {
    return (pixels + StrokeTiles::edge - 1) / StrokeTiles::edge;
}

/// The tiles that pixels are in.
PixelSpan tilesOf(const PixelSpan& pixels) {
    if (pixels.empty()) return {};
    return {pixels.begin / StrokeTiles::edge, (pixels.end - 1) / StrokeTiles::edge + 1};
}

/// Calls visit(column, row) for each tile that a part of a line may touch; of what goes across many, only
/// where it lies within reach of their rows.
template <class Visit>
void forTilesOf(const StrokePoint& from, const StrokePoint& to, double reach, const PixelSpan& size,
                const Visit& visit) {
    const auto [low, high] = std::minmax<double>({from.y, to.y});
    const auto rows = tilesOf(pixelsBetween(low - reach, high + reach, size.end));
    const double down = double{to.y} - from.y, right = double{to.x} - from.x;
    for (auto row = rows.begin; row < rows.end; ++row) {
        double first = 0.0, last = 1.0;
        if (rows.end - rows.begin > 1 && down != 0.0) {
            const double top = row * StrokeTiles::edge - reach,
                         bottom = top + StrokeTiles::edge + 2.0 * reach;
            const auto [one, other] = std::minmax({(top - from.y) / down, (bottom - from.y) / down});
            first = std::clamp(one, 0.0, 1.0);
            last = std::clamp(other, 0.0, 1.0);
        }
        const auto [left, end] = std::minmax({from.x + first * right, from.x + last * right});
        const auto columns = tilesOf(pixelsBetween(left - reach - 1e-3, end + reach + 1e-3, size.begin));
        for (auto column = columns.begin; column < columns.end; ++column) visit(column, row);
    }
}

}  // namespace

StrokeTiles::StrokeTiles(const Strokes& strokes, std::uint32_t width, std::uint32_t height)
    : columns_(tilesOfSide(width)),
      rows_(tilesOfSide(height)),
      reach_(strokes.lines.size()),
      across_(strokes.areas.size()) {
    const auto& points = strokes.points;
    const auto linesOf = [&](std::size_t chunk, const auto& take) {
        const std::size_t end = std::min(strokes.lines.size(), (chunk + 1) * linesOfAChunk);
        for (std::size_t i = chunk * linesOfAChunk; i < end; ++i) take(static_cast<std::uint32_t>(i));
    };
    lines_.fill(
        std::size_t{columns_} * rows_, (strokes.lines.size() + linesOfAChunk - 1) / linesOfAChunk, {},
        [&](std::size_t chunk) {
            linesOf(chunk, [&](std::uint32_t line) {
                float widest = 0.0F;
                for (auto i = strokes.lines[line].begin; i < strokes.lines[line].end; ++i)
                    widest = std::max(widest, points[i].width);
                reach_[line] = widest > 0.0F ? 0.5 * widest + 0.5 : 0.0;
            });
        },
        [&](std::size_t chunk, auto visit) {
            linesOf(chunk, [&](std::uint32_t line) {
                const auto [begin, end] = strokes.lines[line];
                if (!(reach_[line] > 0.0)) return;
                for (auto i = begin; i < std::max(begin + 1, end - 1); ++i) {
                    const auto& to = points[std::min(i + 1, end - 1)];
                    forTilesOf(points[i], to, reach_[line], {width, height},
                               [&](std::uint32_t column, std::uint32_t row) {
                                   visit(std::size_t{row} * columns_ + column, LinePart{line, i});
                               });
                }
            });
        });
    const auto edgesOf = [&](std::size_t area, const auto& take) {
        for (auto i = strokes.areas[area].begin; i < strokes.areas[area].end; ++i) {
            const auto [begin, end] = strokes.outlines[i];
            for (auto j = begin; j < end; ++j) take(j, j + 1 < end ? j + 1 : begin);
        }
    };
    edges_.fill(
        rows_, strokes.areas.size(), {},
        [&](std::size_t area) {
            double left = width, right = 0.0;
            edgesOf(area, [&](std::uint32_t from, std::uint32_t) {
                left = std::min<double>(left, points[from].x);
                right = std::max<double>(right, points[from].x);
            });
            across_[area] = pixelsBetween(left - 1.0, right + 1.0, width);
        },
        [&](std::size_t area, auto visit) {
            edgesOf(area, [&](std::uint32_t from, std::uint32_t to) {
                const auto [low, high] = std::minmax({points[from].y, points[to].y});
                const auto rows = tilesOf(pixelsBetween(low - 1.0, high + 1.0, height));
                for (auto row = rows.begin; row < rows.end; ++row)
                    visit(row, AreaEdge{static_cast<std::uint32_t>(area), from, to});
            });
        });
}

namespace {

/// Fragments of a tile and a list at most: 256 MB.
constexpr std::size_t mostFragments = std::size_t{1} << 23;
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

/// Draws pixels of a tile; of one thread.
class TilePainter {
  public:
    using LineParts = std::span<const StrokeTiles::LinePart>;
    using AreaEdges = std::span<const StrokeTiles::AreaEdge>;

    TilePainter(const Strokes& strokes, const PixelRect& pixels, double nearDepth)
        : strokes_(strokes),
          left_(pixels.left),
          right_(pixels.right),
          top_(pixels.top),
          bottom_(pixels.bottom),
          nearDepth_(nearDepth),
          nearest_(std::size_t{right_ - left_} * (bottom_ - top_)),
          shares_(nearest_.size()) {}

    /// Parts of one line; edges of one area.
    void drawLine(const LineParts& parts, double reach);
    void drawArea(const AreaEdges& edges);
    const Fragments& fragments() const { return fragments_; }

  private:
    /// The place of a line that is nearest to a pixel's middle.
    struct Nearest {
        double distance2 = unseen;       ///< squared pixels
        double half = 0.0, depth = 0.0;  ///< half the line's width
    };
    /// A pixel; its row from the first one on.
    struct Cell {
        std::uint32_t column, row;
    };
    struct RowSpan {
        std::uint32_t row;
        PixelSpan columns;
    };
    struct Crossing {
        std::uint32_t line;  ///< from the first on
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
    std::size_t indexOf(Cell cell) const {
        return std::size_t{cell.row} * (right_ - left_) + (cell.column - left_);
    }

    const Strokes& strokes_;
    const std::uint32_t left_, right_, top_, bottom_;
    const double nearDepth_;
    std::vector<Nearest> nearest_;  // of the pixels, row by row
    std::vector<RowSpan> spans_;    // where a line may be near; a pixel may be in several
    std::vector<double> shares_;    // of the pixels that an area covers
    std::vector<Crossing> crossings_;
    Fragments fragments_;
};

void TilePainter::drawLine(const LineParts& parts, double reach) {
    const auto end = strokes_.lines[parts.front().line].end;
    for (const auto& [line, point] : parts)
        approach(strokes_.points[point], strokes_.points[std::min(point + 1, end - 1)], reach);
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
void TilePainter::approach(const StrokePoint& from, const StrokePoint& to, double reach) {
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
        const auto columns =
            pixelsBetween(std::min(begin, end) - reach, std::max(begin, end) + reach, right_);
        approachRow(row - top_, {std::max(columns.begin, left_), columns.end}, segment);
    }
}

/// Without branches, which could not be foretold.
void TilePainter::approachRow(std::uint32_t row, PixelSpan columns, const Segment& segment) {
    if (columns.empty()) return;
    spans_.push_back({row, columns});
    Nearest* const cells = &nearest_[indexOf({columns.begin, row})];
    const double y = top_ + row + 0.5 - segment.y, yAlong = y * segment.down;
    for (auto column = columns.begin; column < columns.end; ++column) {
        const double x = column + 0.5 - segment.x;
        const double share = heldToUnit((x * segment.right + yAlong) * segment.perLength2);
        const double acrossX = x - share * segment.right, acrossY = y - share * segment.down;
        const double distance2 = acrossX * acrossX + acrossY * acrossY;
        Nearest& nearest = cells[column - columns.begin];
        const bool nearer = distance2 < nearest.distance2;
        nearest.half = nearer ? segment.half + share * segment.wider : nearest.half;
        nearest.depth = nearer ? segment.depth + share * segment.deeper : nearest.depth;
        nearest.distance2 = nearer ? distance2 : nearest.distance2;
    }
}

void TilePainter::drawArea(const AreaEdges& edges) {
    crossings_.clear();
    for (const auto& [area, from, to] : edges) cross(strokes_.points[from], strokes_.points[to]);
    if (crossings_.empty()) return;
    std::sort(crossings_.begin(), crossings_.end());
    double left = right_, right = left_;
    // Each line is crossed an even number of times.
    for (std::size_t i = 0; i + 1 < crossings_.size(); i += 2) {
        const double from = std::clamp<double>(crossings_[i].x, left_, right_);
        const double to = std::clamp<double>(crossings_[i + 1].x, left_, right_);
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
void TilePainter::cross(const StrokePoint& from, const StrokePoint& to) {
    const auto [low, high] = std::minmax({from.y, to.y});
    const auto firstLine = [&](double y) {
        const double line = std::ceil((y - top_) * rowLines - 0.5);
        return static_cast<std::uint32_t>(std::clamp<double>(line, 0.0, (bottom_ - top_) * rowLines));
    };
    const double slope = (double{to.x} - from.x) / (double{to.y} - from.y);
    for (auto line = firstLine(low), end = firstLine(high); line < end; ++line)
        crossings_.push_back({line, from.x + (top_ + (line + 0.5) / rowLines - from.y) * slope});
}

void TilePainter::addSpan(std::uint32_t row, double left, double right) {
    if (!(left < right)) return;
    double* const shares = &shares_[indexOf({left_, row})];
    left -= left_;
    right -= left_;
    const auto first = static_cast<std::uint32_t>(left), last = static_cast<std::uint32_t>(right);
    if (first == last) {
        shares[first] += (right - left) / rowLines;
        return;
    }
    shares[first] += (first + 1 - left) / rowLines;
    for (auto column = first + 1; column < last; ++column) shares[column] += 1.0 / rowLines;
    if (last < right_ - left_) shares[last] += (right - last) / rowLines;
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

/// The first of a list that are alike.
template <class Item>
std::span<const Item> takeAlike(std::span<const Item>& list, std::uint32_t Item::*number) {
    std::size_t count = 1;
    while (count < list.size() && list[count].*number == list[0].*number) ++count;
    const auto first = list.first(count);
    list = list.subspan(count);
    return first;
}

}  // namespace

void StrokeFragments::make(const PixelRect& pixels, Fragments& fragments) const {
    constexpr auto edge = StrokeTiles::edge;
    for (auto row = pixels.top / edge; row < tiles_.rows() && row * edge < pixels.bottom; ++row) {
        for (auto column = pixels.left / edge; column < tiles_.columns() && column * edge < pixels.right;
             ++column) {
            const PixelRect part{std::max(pixels.left, column * edge), std::max(pixels.top, row * edge),
                                 std::min({pixels.right, (column + 1) * edge, width_}),
                                 std::min({pixels.bottom, (row + 1) * edge, height_})};
            if (!part.empty()) makeTile(column, row, part, fragments);
        }
    }
}

void StrokeFragments::makeTile(std::uint32_t column, std::uint32_t row, const PixelRect& pixels,
                               Fragments& fragments) const {
    auto lines = tiles_.lines(column, row);
    auto edges = tiles_.edges(row);
    if (lines.empty() && edges.empty()) return;
    TilePainter painter(*strokes_, pixels, nearDepth_);
    const auto check = [&] {
        if (painter.fragments().size() > mostFragments) throw std::bad_alloc();
    };
    while (!lines.empty()) {
        const auto line = takeAlike(lines, &StrokeTiles::LinePart::line);
        painter.drawLine(line, tiles_.reach(line[0].line));
        check();
    }
    while (!edges.empty()) {
        const auto area = takeAlike(edges, &StrokeTiles::AreaEdge::area);
        const auto& across = tiles_.across(area[0].area);
        if (across.begin < pixels.right && across.end > pixels.left) painter.drawArea(area);
        check();
    }
    if (strokes_->opacity < 1.0F) {
        auto faded = painter.fragments();
        fade(faded, static_cast<double>(strokes_->opacity));
        fragments.insert(fragments.end(), faded.begin(), faded.end());
        return;
    }
    fragments.insert(fragments.end(), painter.fragments().begin(), painter.fragments().end());
}

std::vector<Fragments> strokeFragments(const Strokes& strokes, std::uint32_t width, std::uint32_t height,
                                       double nearDepth) {
    const std::shared_ptr<const Strokes> same(std::shared_ptr<const Strokes>(), &strokes);
    const StrokeFragments all(same, width, height, nearDepth);
    std::vector<Fragments> parts((height + StrokeTiles::edge - 1) / StrokeTiles::edge);
    forInTurns(std::size_t{0}, parts.size(), [&](std::size_t i) {
        const auto top = static_cast<std::uint32_t>(i) * StrokeTiles::edge;
        all.make({0, top, width, std::min(top + StrokeTiles::edge, height)}, parts[i]);
    });
    return parts;
}

}  // namespace mote::render
