// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/contrast/depth_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

// Lengths in pixels of a picture of 720 lines; a contour and the halo beside it, as deviations of Gaussians.
constexpr double readingDistance = 6.0, haloWidth = 4.5, lineWidth = 1.0;
constexpr std::uint32_t widePasses = 3, narrowPasses = 2;
constexpr double depthStep = 0.02;             // of the extent: what differs by more is an edge
constexpr double halo = 0.85;                  // opacity where all is ambiguous
constexpr float leastOpacity = 1.0F / 512.0F;  // of a mark: less is nothing
constexpr float leastWeight = 1e-4F;           // of a layer's pixels around one: less is none
constexpr double liftedBy = 1e-3;              // of the extent, before what a mark belongs to
constexpr std::uint32_t side = 128;            // of a tile, pixels

/// From 0 to 1, evenly where it begins and ends.
double easedBetween(double value, double from, double to) {
    const double x = std::clamp((value - from) / (to - from), 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

/// Running means of 2 radius + 1 values, so often that they come near a Gaussian.
struct Blur {
    std::uint32_t radius, passes;

    static Blur of(double deviation, std::uint32_t passes) {
        const double width = std::sqrt(12.0 * deviation * deviation / passes + 1.0);
        return {std::max(1U, static_cast<std::uint32_t>(std::lround(0.5 * (width - 1.0)))), passes};
    }
    std::uint32_t reach() const { return radius * passes; }
    double deviation() const {
        return std::sqrt(passes * ((2.0 * radius + 1.0) * (2.0 * radius + 1.0) - 1.0) / 12.0);
    }
};

/// A part of a picture, row by row.
struct Patch {
    std::uint32_t width = 0, height = 0;
    std::vector<float> values;

    Patch(std::uint32_t columns, std::uint32_t rows)
        : width(columns), height(rows), values(std::size_t{columns} * rows) {}
    float* row(std::uint32_t y) { return values.data() + std::size_t{y} * width; }
    float at(std::uint32_t x, std::uint32_t y) const { return values[std::size_t{y} * width + x]; }
};

/// Means along a row; beside it there is nothing.
void blurRow(const float* from, float* to, std::uint32_t width, std::uint32_t radius, float weight) {
    float sum = 0.0F;
    for (std::uint32_t i = 0; i < std::min(radius, width); ++i) sum += from[i];
    for (std::uint32_t i = 0; i < width; ++i) {
        if (i + radius < width) sum += from[i + radius];
        to[i] = weight * sum;
        if (i >= radius) sum -= from[i - radius];
    }
}

/// The same down all columns at once.
void blurColumns(Patch& from, Patch& to, std::uint32_t radius, float weight, std::vector<float>& sums) {
    sums.assign(from.width, 0.0F);
    const auto add = [&](std::uint32_t y, float sign) {
        const float* const row = from.row(y);
        for (std::uint32_t x = 0; x < from.width; ++x) sums[x] += sign * row[x];
    };
    for (std::uint32_t y = 0; y < std::min(radius, from.height); ++y) add(y, 1.0F);
    for (std::uint32_t y = 0; y < from.height; ++y) {
        if (y + radius < from.height) add(y + radius, 1.0F);
        float* const row = to.row(y);
        for (std::uint32_t x = 0; x < from.width; ++x) row[x] = weight * sums[x];
        if (y >= radius) add(y - radius, -1.0F);
    }
}

/// Right for what lies as far inside as the blur reaches.
void blur(Patch& patch, const Blur& how, Patch& other, std::vector<float>& sums) {
    const float weight = 1.0F / static_cast<float>(2 * how.radius + 1);
    for (std::uint32_t pass = 0; pass < how.passes; ++pass) {
        for (std::uint32_t y = 0; y < patch.height; ++y)
            blurRow(patch.row(y), other.row(y), patch.width, how.radius, weight);
        blurColumns(other, patch, how.radius, weight, sums);
    }
}

/// What a layer is around each pixel of a patch, blurred: its weight among all pixels, near and around, and
/// means over its own.
struct Around {
    Patch line, weight, depth, front, share, tone;

    Around(std::uint32_t width, std::uint32_t height)
        : line(width, height),
          weight(width, height),
          depth(width, height),
          front(width, height),
          share(width, height),
          tone(width, height) {}
};

/// A fragment of a tile: of the nearer layer's contour, or of what holds the farther back.
struct ContrastMark {
    float depth, opacity;
    std::uint8_t column;  // in the tile
    bool contour;
};

struct MarkTile {
    std::vector<ContrastMark> marks;           // row by row
    std::array<std::uint32_t, side + 1> rows;  // where each begins
};

class ContrastMarks : public FragmentMaker {
  public:
    ContrastMarks(std::uint32_t columns, std::vector<MarkTile> tiles, const ContrastStyle& style)
        : columns_(columns), tiles_(std::move(tiles)), style_(style) {}

    void make(const PixelRect& pixels, Fragments& fragments) const override {
        if (pixels.empty()) return;
        for (auto row = pixels.top; row < pixels.bottom; ++row) {
            for (auto tile = pixels.left / side; tile <= (pixels.right - 1) / side; ++tile)
                addRow(tile, row, pixels, fragments);
        }
    }

  private:
    void addRow(std::uint32_t column, std::uint32_t row, const PixelRect& pixels,
                Fragments& fragments) const {
        const auto& tile = tiles_[std::size_t{row / side} * columns_ + column];
        if (tile.marks.empty()) return;
        for (auto i = tile.rows[row % side]; i < tile.rows[row % side + 1]; ++i) {
            const auto& mark = tile.marks[i];
            const std::uint32_t at = column * side + mark.column;
            if (at < pixels.left || at >= pixels.right) continue;
            fragments.push_back({.column = at,
                                 .row = row,
                                 .depth = static_cast<double>(mark.depth),
                                 .opacity = mark.opacity,
                                 .color = mark.contour ? style_.contour : style_.background});
        }
    }

    const std::uint32_t columns_;  // of tiles
    const std::vector<MarkTile> tiles_;
    const ContrastStyle style_;
};

/// Whether something else is seen in a pixel than in the next one.
bool isEdge(const DepthOrder& order, std::size_t one, std::size_t other) {
    const auto a = order.layer.values[one], b = order.layer.values[other];
    if (a != b) return true;
    if (a == DepthOrder::nothing) return false;
    return std::abs(order.depth.values[one] - order.depth.values[other]) >
           static_cast<float>(depthStep * order.extent);
}

/// Makes the marks of tiles, one after another.
class TileMaker {
  public:
    TileMaker(const DepthOrder& order, const ContrastStyle& style)
        : order_(order),
          style_(style),
          reading_(Blur::of(readingDistance * style.pixels, widePasses)),
          wide_(Blur::of(haloWidth * style.pixels, widePasses)),
          narrow_(Blur::of(lineWidth * style.pixels, narrowPasses)),
          margin_(std::max(reading_.reach(), wide_.reach())) {}

    /// How far from where two layers meet anything is drawn.
    std::uint32_t reach() const { return wide_.reach(); }

    MarkTile make(std::uint32_t left, std::uint32_t top) {
        const auto& layer = order_.layer;
        left_ = left > margin_ ? left - margin_ : 0;
        top_ = top > margin_ ? top - margin_ : 0;
        width_ = std::min(left + side + margin_, layer.width) - left_;
        height_ = std::min(top + side + margin_, layer.height) - top_;
        gather();
        MarkTile made;
        for (std::uint32_t row = 0; row < side; ++row) {
            made.rows[row] = static_cast<std::uint32_t>(made.marks.size());
            if (layers_.size() < 2 || top + row >= layer.height) continue;
            for (std::uint32_t column = 0; column < std::min(side, layer.width - left); ++column)
                addPixel(left + column, top + row, static_cast<std::uint8_t>(column), made.marks);
        }
        made.rows[side] = static_cast<std::uint32_t>(made.marks.size());
        made.marks.shrink_to_fit();
        return made;
    }

  private:
    std::size_t indexOf(std::uint32_t x, std::uint32_t y) const {
        return order_.layer.index(left_ + x, top_ + y);
    }
    template <class Value>
    void fill(Patch& patch, const Value& value) const {
        for (std::uint32_t y = 0; y < height_; ++y) {
            for (std::uint32_t x = 0; x < width_; ++x) patch.row(y)[x] = value(indexOf(x, y));
        }
    }
    void soften(Patch& patch, const Blur& how) { blur(patch, how, *other_, sums_); }

    void gather() {
        layers_.clear();
        around_.clear();
        ends_.clear();
        std::array<bool, DepthOrder::nothing + 1> seen{};
        for (std::uint32_t y = 0; y < height_; ++y) {
            for (std::uint32_t x = 0; x < width_; ++x) seen[order_.layer.values[indexOf(x, y)]] = true;
        }
        for (std::size_t i = 0; i < order_.own.size(); ++i) {
            if (seen[i]) layers_.push_back(static_cast<std::uint8_t>(i));
        }
        if (layers_.size() < 2) return;
        other_.emplace(width_, height_);
        for (const auto i : layers_) addLayer(i);
        for (const auto near : layers_) {
            for (const auto far : layers_) addEnds(near, far);
        }
        complexity_.emplace(width_, height_);
        fill(*complexity_, [this](std::size_t i) { return edgeAt(i); });
        soften(*complexity_, reading_);
    }
    float edgeAt(std::size_t i) const {
        const std::size_t columns = order_.layer.width, all = order_.layer.values.size();
        const bool right = (i + 1) % columns != 0 && isEdge(order_, i, i + 1);
        const bool below = i + columns < all && isEdge(order_, i, i + columns);
        return right || below ? 1.0F : 0.0F;
    }
    void addLayer(std::uint8_t number) {
        auto& made = around_.emplace_back(width_, height_);
        const auto of = [&](Patch& patch, const Raster<float>* values, const Blur& how) {
            fill(patch, [&](std::size_t i) {
                if (order_.layer.values[i] != number) return 0.0F;
                return values != nullptr ? values->values[i] : 1.0F;
            });
            soften(patch, how);
        };
        of(made.line, nullptr, narrow_);
        of(made.weight, nullptr, wide_);
        of(made.depth, &order_.depth, wide_);
        of(made.front, &order_.front, wide_);
        of(made.share, &order_.share, wide_);
        of(made.tone, &order_.tone, wide_);
    }
    /// Where the farther layer is seen and there is nothing of the nearer.
    void addEnds(std::uint8_t near, std::uint8_t far) {
        auto& made = ends_.emplace_back(width_, height_);
        if (near == far) return;
        const auto& own = order_.own[near].values;
        fill(made, [&](std::size_t i) {
            return order_.layer.values[i] == far ? 1.0F - static_cast<float>(own[i]) / 255.0F : 0.0F;
        });
        soften(made, wide_);
    }

    void addPixel(std::uint32_t column, std::uint32_t row, std::uint8_t inTile,
                  std::vector<ContrastMark>& marks) {
        const std::uint32_t x = column - left_, y = row - top_;
        for (std::size_t near = 0; near < layers_.size(); ++near) {
            for (std::size_t far = 0; far < layers_.size(); ++far) {
                const auto& a = around_[near];
                const auto& b = around_[far];
                if (near == far || !(a.weight.at(x, y) > leastWeight) || !(b.weight.at(x, y) > leastWeight))
                    continue;
                addPair(near, far, x, y, inTile, marks);
            }
        }
    }
    static double mean(const Patch& sums, const Patch& weights, std::uint32_t x, std::uint32_t y) {
        return static_cast<double>(sums.at(x, y)) / static_cast<double>(weights.at(x, y));
    }
    void addPair(std::size_t near, std::size_t far, std::uint32_t x, std::uint32_t y, std::uint8_t inTile,
                 std::vector<ContrastMark>& marks) {
        const auto &a = around_[near], &b = around_[far];
        const auto of = [&](const Around& one, const Patch Around::*what) {
            return mean(one.*what, one.weight, x, y);
        };
        const double lone = 1.0 / (reading_.deviation() * std::sqrt(2.0 * std::numbers::pi));
        const Ambiguity ambiguity{.complexity = static_cast<double>(complexity_->at(x, y)) / lone,
                                  .shares = std::min(of(a, &Around::share), of(b, &Around::share)),
                                  .gap = (of(b, &Around::depth) - of(a, &Around::depth)) / order_.extent,
                                  .ends = mean(ends_[near * layers_.size() + far], b.weight, x, y),
                                  .tones = std::abs(of(a, &Around::tone) - of(b, &Around::tone))};
        const double amount = style_.amount * ambiguity.amount();
        if (!(amount > 0.0)) return;
        const auto weights = [&](const Patch Around::*what) {
            return std::pair(static_cast<double>((a.*what).at(x, y)),
                             static_cast<double>((b.*what).at(x, y)));
        };
        const auto [inner, outer] = weights(&Around::weight);
        const auto [left, right] = weights(&Around::line);
        const double beside = 4.0 * inner * outer, onLine = 4.0 * left * right;
        // Farther from both than a line is wide the wide means tell the side.
        const double within =
            left + right > double{leastWeight} ? left / (left + right) : inner / (inner + outer);
        const double contour = 1.0 - (1.0 - amount * style_.line * onLine) *
                                         (1.0 - amount * style_.rim * beside * std::min(1.0, 2.0 * within));
        const double held = amount * halo * beside * std::min(1.0, 2.0 * (1.0 - within));
        const double lift = liftedBy * order_.extent;
        double front = of(a, &Around::front);
        const std::size_t i = indexOf(x, y);
        if (order_.layer.values[i] == layers_[near])
            front = std::min(front, static_cast<double>(order_.front.values[i]));
        const double behind = of(a, &Around::depth) +
                              std::max(2.0 * lift, 0.5 * (of(b, &Around::front) - of(a, &Around::depth)));
        put({static_cast<float>(front - lift), static_cast<float>(contour), inTile, true}, marks);
        put({static_cast<float>(behind), static_cast<float>(held), inTile, false}, marks);
    }
    static void put(const ContrastMark& mark, std::vector<ContrastMark>& marks) {
        if (mark.opacity > leastOpacity) marks.push_back(mark);
    }

    const DepthOrder& order_;
    const ContrastStyle style_;
    const Blur reading_, wide_, narrow_;
    const std::uint32_t margin_;
    // Of the tile at hand.
    std::uint32_t left_ = 0, top_ = 0, width_ = 0, height_ = 0;  // of its patches, pixels of the picture
    std::vector<std::uint8_t> layers_;                           // that are seen in them
    std::vector<Around> around_;                                 // one a layer
    std::vector<Patch> ends_;                                    // nearer by farther layer
    std::optional<Patch> complexity_, other_;
    std::vector<float> sums_;
};

/// Tiles, of so many in a row, near which two layers meet.
std::vector<std::uint8_t> meetings(const DepthOrder& order, std::uint32_t columns, std::uint32_t rows,
                                   std::uint32_t reach) {
    std::vector<std::uint8_t> tiles(std::size_t{columns} * rows);
    const auto& layer = order.layer;
    const auto meet = [&](std::size_t i, std::size_t other) {
        const auto a = layer.values[i], b = layer.values[other];
        return a != b && a != DepthOrder::nothing && b != DepthOrder::nothing;
    };
    for (std::uint32_t y = 0; y < layer.height; ++y) {
        giveWay();
        for (std::uint32_t x = 0; x < layer.width; ++x) {
            const std::size_t i = layer.index(x, y);
            const bool right = x + 1 < layer.width && meet(i, i + 1);
            const bool below = y + 1 < layer.height && meet(i, i + layer.width);
            if (!right && !below) continue;
            const std::uint32_t firstRow = (y > reach ? y - reach : 0) / side,
                                lastRow = std::min(rows - 1, (y + 1 + reach) / side);
            const std::uint32_t first = (x > reach ? x - reach : 0) / side,
                                last = std::min(columns - 1, (x + 1 + reach) / side);
            for (auto row = firstRow; row <= lastRow; ++row) {
                for (auto column = first; column <= last; ++column)
                    tiles[std::size_t{row} * columns + column] = 1;
            }
        }
    }
    return tiles;
}

}  // namespace

DepthOrder::DepthOrder(std::uint32_t width, std::uint32_t height, std::size_t layers)
    : layer(width, height, nothing),
      depth(width, height),
      front(width, height),
      share(width, height),
      tone(width, height) {
    for (std::size_t i = 0; i < layers; ++i) own.emplace_back(width, height);
}

double contrastReach(double pixels) {
    return Blur::of(haloWidth * pixels, widePasses).reach() +
           Blur::of(readingDistance * pixels, widePasses).reach() + 1;
}

double Ambiguity::amount() const {
    constexpr double fullGap = 0.03, toldByTone = 0.5;
    const double crowded = std::clamp(complexity - 0.25, 0.0, 1.0);
    const double told = std::clamp(tones / toldByTone, 0.0, 1.0);
    return crowded * easedBetween(shares, 0.1, 0.5) * easedBetween(gap, 0.0, fullGap) * ends * (1.0 - told);
}

std::shared_ptr<const FragmentMaker> contrastOf(const DepthOrder& order, const ContrastStyle& style,
                                                const std::stop_token& stop) {
    if (!(style.amount > 0.0)) return nullptr;
    const std::uint32_t columns = (order.layer.width + side - 1) / side,
                        rows = (order.layer.height + side - 1) / side;
    const auto wanted = meetings(order, columns, rows, TileMaker(order, style).reach());
    std::vector<MarkTile> tiles(wanted.size());
    forInTurns(std::size_t{0}, wanted.size(), [&](std::size_t i) {
        if (wanted[i] == 0 || isStopped(stop)) return;
        const auto column = static_cast<std::uint32_t>(i % columns),
                   row = static_cast<std::uint32_t>(i / columns);
        tiles[i] = TileMaker(order, style).make(column * side, row * side);
    });
    if (std::all_of(tiles.begin(), tiles.end(), [](const MarkTile& tile) { return tile.marks.empty(); }))
        return nullptr;
    return std::make_shared<const ContrastMarks>(columns, std::move(tiles), style);
}

}  // namespace mote::render
