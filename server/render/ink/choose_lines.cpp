// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/choose_lines.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>
#include <utility>

#include "server/render/ink/contour.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

/// By so much all lines are darker than the target where some are left out, share of the paper.
constexpr double tooDark = 0.02;
/// Lines that are always drawn are not where they alone are so much darker than the target: a tree is not
/// all ink.
constexpr double crowdOfImportant = 0.4;
/// Step of a line beside nothing, an outer contour.
constexpr float outerStep = 0.999F;
/// Lines that were left before are so much less important.
constexpr float staysLeft = 1.5F;
/// Of a line in a film, pixels between places at which it is told whether it was drawn before.
constexpr double toldEvery = 0.5;
/// Pixels within which a line stands for an outer contour, and within which it is sought first.
constexpr double contourReach = 1.9, contourNear = 0.7;
/// By so much too light it is where lines come back that were left before, share of the paper.
constexpr double slack = 0.1;

/// What is drawn or left out as one: segments of a line from `begin` to `end`.
struct Piece {
    std::uint32_t line = 0, begin = 0, end = 0;
    float importance = 0.0F;
    LineBefore before = LineBefore::unknown;
    bool drawn = false;
};

/// Ink in a cell of a grid.
struct Drop {
    std::uint32_t column, row;
    double cover;
};

double lengthOf(const InkLine& line, std::size_t segment) {
    return glm::distance(line.points[segment].at, line.points[segment + 1].at);
}

/// Lines of a film with places so near each other that each part was drawn or was not.
std::vector<InkLine> finely(const std::vector<InkLine>& lines) {
    std::vector<InkLine> made;
    made.reserve(lines.size());
    for (const auto& line : lines) {
        giveWay();
        InkLine fine{line.kind, {line.points.front()}, line.rank};
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
            const auto &from = line.points[i], &to = line.points[i + 1];
            const auto parts =
                static_cast<int>(std::clamp(std::ceil(lengthOf(line, i) / toldEvery), 1.0, 4096.0));
            for (int part = 1; part < parts; ++part) {
                const double share = static_cast<double>(part) / parts;
                fine.points.push_back(
                    {glm::mix(from.at, to.at, share), std::lerp(from.depth, to.depth, share), from.step});
            }
            fine.points.push_back(to);
        }
        made.push_back(std::move(fine));
    }
    return made;
}

std::vector<Piece> piecesOf(const std::vector<InkLine>& lines, double longest, const Carry* carry) {
    std::vector<Piece> pieces;
    std::vector<std::vector<LineBefore>> states(lines.size());
    if (carry != nullptr) states = carry->linesBefore(lines);
    for (std::uint32_t i = 0; i < lines.size(); ++i) {
        const auto segments = static_cast<std::uint32_t>(lines[i].points.size()) - 1;
        auto& before = states[i];
        before.resize(segments, LineBefore::unknown);
        Piece piece{.line = i};
        double length = 0.0, steps = 0.0;
        for (std::uint32_t k = 0; k < segments; ++k) {
            const double more = lengthOf(lines[i], k);
            length += more;
            steps += more * lines[i].points[k].step;
            if (length < longest && k + 1 < segments && before[k + 1] == before[k]) continue;
            piece.end = k + 1;
            piece.before = before[k];
            piece.importance = length > 0.0 ? static_cast<float>(steps / length) : 0.0F;
            pieces.push_back(piece);
            piece.begin = piece.end;
            length = steps = 0.0;
        }
    }
    return pieces;
}

/// A drop of ink as the eye blurs it. At a grid's sides, beyond which no ink is known, what lies inside
/// counts for all.
class Blot {
  public:
    Blot(double deviation, const ToneCells& cells) : reach_(static_cast<int>(std::ceil(3.0 * deviation))) {
        double sum = 0.0;
        for (int i = -reach_; i <= reach_; ++i) {
            weights_.push_back(std::exp(-0.5 * i * i / (deviation * deviation)));
            sum += weights_.back();
        }
        for (auto& weight : weights_) weight /= sum;
        columns_ = shares(cells.columns);
        rows_ = shares(cells.rows);
    }
    /// take(cell, weight) for all cells of a grid around one.
    template <class Take>
    void each(const ToneGrid& grid, const Drop& drop, const Take& take) const {
        const auto column = static_cast<int>(drop.column), row = static_cast<int>(drop.row);
        const int left = std::max(0, column - reach_), top = std::max(0, row - reach_);
        const int right = std::min(static_cast<int>(grid.width) - 1, column + reach_);
        const int bottom = std::min(static_cast<int>(grid.height) - 1, row + reach_);
        for (int y = top; y <= bottom; ++y) {
            const double across = drop.cover * weightOf(y - row) / rows_[static_cast<std::size_t>(y)];
            const std::size_t first = grid.index(0, static_cast<std::uint32_t>(y));
            for (int x = left; x <= right; ++x)
                take(first + static_cast<std::size_t>(x),
                     across * weightOf(x - column) / columns_[static_cast<std::size_t>(x)]);
        }
    }

  private:
    /// Of a cell that is at most `reach_` away.
    double weightOf(int away) const {
        const int place = reach_ + away;
        return weights_[static_cast<std::size_t>(place)];
    }
    /// What of the blot around each of some cells lies among them.
    std::vector<double> shares(std::uint32_t cells) const {
        std::vector<double> inside(cells);
        const auto count = static_cast<int>(cells);
        for (int at = 0; at < count; ++at) {
            const int last = std::min(reach_, count - 1 - at);
            for (int i = std::max(-reach_, -at); i <= last; ++i)
                inside[static_cast<std::size_t>(at)] += weightOf(i);
        }
        return inside;
    }

    int reach_;
    std::vector<double> weights_;         // of cells by their distance
    std::vector<double> columns_, rows_;  // shares() of them
};

template <class Take>
void eachDrop(const InkLine& line, std::size_t begin, std::size_t end, const ToneCells& cells, double width,
              const Take& take) {
    const double pixels = cells.pixels;
    for (std::size_t i = begin; i < end; ++i) {
        eachSquare(line.points[i].at / pixels, line.points[i + 1].at / pixels, cells.columns, cells.rows,
                   [&](std::uint32_t column, std::uint32_t row, double length) {
                       if (length > 0.0) take(Drop{column, row, length * width / pixels});
                   });
    }
}

/// Tries pieces one after another: each is drawn where the squared error of the tone grows less by it.
class Trial {
  public:
    Trial(const std::vector<InkLine>& lines, const LineTarget& target)
        : lines_(lines),
          cells_(target.cells),
          width_(target.width),
          blot_(cells_.blur, cells_),
          drawn_(cells_.columns, cells_.rows),
          wanted_(cells_.columns, cells_.rows),
          weight_(cells_.columns, cells_.rows),
          change_(cells_.columns, cells_.rows) {
        for (std::size_t i = 0; i < wanted_.values.size(); ++i) {
            const double cover = std::clamp(static_cast<double>(target.target.values[i]), 0.0, mostCover);
            wanted_.values[i] = static_cast<float>(densityOf(cover));
            // Near the target a change of density changes the tone by so much.
            weight_.values[i] = static_cast<float>((1.0 - cover) * (1.0 - cover));
        }
    }

    void draw(Piece& piece) {
        piece.drawn = true;
        spread(piece);
        for (const auto cell : touched_) drawn_.values[cell] += std::exchange(change_.values[cell], 0.0F);
        touched_.clear();
    }
    void tryOne(Piece& piece) {
        spread(piece);
        double error = 0.0;
        const double lean = leanOf(piece);
        for (const auto cell : touched_) {
            const double more = static_cast<double>(change_.values[cell]);
            // A share of the paper is a greater density the darker it is.
            const double wanted = static_cast<double>(wanted_.values[cell]) +
                                  lean / std::sqrt(static_cast<double>(weight_.values[cell]));
            const double off = static_cast<double>(drawn_.values[cell]) - wanted;
            error += static_cast<double>(weight_.values[cell]) * more * (2.0 * off + more);
        }
        piece.drawn = error < 0.0;
        for (const auto cell : touched_) {
            const float more = std::exchange(change_.values[cell], 0.0F);
            if (piece.drawn) drawn_.values[cell] += more;
        }
        touched_.clear();
    }
    /// Whether it lies where all lines would be too dark.
    bool crowded(const Piece& piece, const ToneGrid& all, double slackOfTone = tooDark) const {
        const auto& middle = lines_[piece.line].points[(piece.begin + piece.end) / 2].at;
        const double cover = coverOf(static_cast<double>(toneAt(all, cells_, middle)));
        return cover >
               coverOf(static_cast<double>(toneAt(wanted_, cells_, middle))) + slackOfTone + leanOf(piece);
    }
    /// The density of some pieces.
    template <class Which>
    ToneGrid densityOfThose(const std::vector<Piece>& pieces, const Which& which) const {
        ToneGrid grid(cells_.columns, cells_.rows);
        for (const auto& piece : pieces) {
            if (!which(piece)) continue;
            eachDrop(lines_[piece.line], piece.begin, piece.end, cells_, width_, [&](const Drop& drop) {
                grid.at(drop.column, drop.row) += static_cast<float>(drop.cover);
            });
        }
        return blurred(grid, cells_.blur);
    }
    ToneGrid take() { return std::move(drawn_); }

  private:
    /// By how much darker the target counts for a piece.
    static double leanOf(const Piece& piece) { return piece.before == LineBefore::left ? -slack : 0.0; }
    /// What the piece would add, in change_.
    void spread(const Piece& piece) {
        eachDrop(lines_[piece.line], piece.begin, piece.end, cells_, width_, [&](const Drop& drop) {
            blot_.each(change_, drop, [&](std::size_t cell, double more) {
                if (change_.values[cell] == 0.0F) touched_.push_back(cell);
                change_.values[cell] += static_cast<float>(more);
            });
        });
    }

    const std::vector<InkLine>& lines_;
    const ToneCells& cells_;
    const double width_;
    const Blot blot_;
    ToneGrid drawn_, wanted_, weight_, change_;
    std::vector<std::size_t> touched_;
};

/// What was left before and is an outer contour now comes only where its place has no other line.
float importanceOf(const Piece& piece) {
    if (piece.before != LineBefore::left) return piece.importance;
    return piece.importance >= outerStep ? 0.0F : piece.importance / staysLeft;
}

/// Outer contours are whole, whatever the style says.
bool isImportant(float step, const SilhouetteStyle& style) {
    return static_cast<double>(step) > style.importance || step >= outerStep;
}

void adjust(std::vector<Piece>& pieces, const std::vector<InkLine>& lines, const SilhouetteStyle& style,
            const LineTarget& target, Trial& trial, const std::stop_token& stop) {
    const ToneGrid all = densityOf(lines, target.cells, target.width);
    const auto important = [&](const Piece& piece) { return isImportant(importanceOf(piece), style); };
    const ToneGrid always = trial.densityOfThose(pieces, important);
    std::vector<Piece*> tried;
    for (auto& piece : pieces) {
        if (isStopped(stop)) return;
        if (piece.before == LineBefore::drawn ||
            (important(piece) && !trial.crowded(piece, always, crowdOfImportant)) ||
            !trial.crowded(piece, all))
            trial.draw(piece);
        else
            tried.push_back(&piece);
    }
    std::stable_sort(tried.begin(), tried.end(),
                     [](const Piece* a, const Piece* b) { return a->importance > b->importance; });
    for (Piece* const piece : tried) {
        if (!isStopped(stop)) trial.tryOne(*piece);
    }
}

/// The share that is wanted of a crowd is drawn, the same lines in every picture. Importance is that of a
/// line's first segment: these lines are short.
ChosenLines thinned(const std::vector<InkLine>& lines, const SilhouetteStyle& style,
                    const LineTarget& target) {
    const ToneGrid all = densityOf(lines, target.cells, target.width);
    ChosenLines chosen;
    for (const auto& line : lines) {
        const auto& place = line.points.front();
        const double wanted = densityOf(static_cast<double>(toneAt(target.target, target.cells, place.at)));
        const double share =
            wanted / std::max(static_cast<double>(toneAt(all, target.cells, place.at)), 1e-6);
        const bool drawn =
            isImportant(static_cast<float>(place.step), style) || static_cast<double>(line.rank) < share;
        (drawn ? chosen.lines : chosen.left).push_back(line);
    }
    chosen.density = densityOf(chosen.lines, target.cells, target.width);
    return chosen;
}

/// take(column, row, right) for each border between a pixel that sees something and one that sees nothing:
/// the one to the right of it, or the one below.
template <class Take>
void eachBorder(const Raster<Sight>& sight, const Take& take) {
    const auto parts = [](Sight one, Sight other) {
        return one != other && (one == Sight::nothing || other == Sight::nothing) && one != Sight::inked &&
               other != Sight::inked;
    };
    for (std::uint32_t row = 0; row < sight.height; ++row) {
        giveWay();
        for (std::uint32_t column = 0; column < sight.width; ++column) {
            const Sight one = sight.at(column, row);
            if (column + 1 < sight.width && parts(one, sight.at(column + 1, row))) take(column, row, true);
            if (row + 1 < sight.height && parts(one, sight.at(column, row + 1))) take(column, row, false);
        }
    }
}

/// Places at the borders of what is seen that no line stands for yet.
class BareBorders {
  public:
    explicit BareBorders(const Raster<Sight>& sight)
        : columns_(sight.width / square + 1),
          rows_(sight.height / square + 1),
          squares_(std::size_t{columns_} * rows_) {
        eachBorder(sight, [&](std::uint32_t column, std::uint32_t row, bool right) {
            const glm::vec2 place(static_cast<float>(column) + (right ? 1.0F : 0.5F),
                                  static_cast<float>(row) + (right ? 0.5F : 1.0F));
            squares_[std::size_t{row / square} * columns_ + column / square].push_back(place);
        });
    }

    /// Whether any is within a distance of a line, pixels.
    bool anyBeside(const LinePoint& from, const LinePoint& to, double reach) {
        bool any = false;
        eachBeside(from, to, reach, [&](auto&, std::size_t) {
            any = true;
            return false;
        });
        return any;
    }
    /// A line stands for those beside it.
    void cover(const LinePoint& from, const LinePoint& to) {
        eachBeside(from, to, contourReach, [](std::vector<glm::vec2>& places, std::size_t i) {
            places[i] = places.back();
            places.pop_back();
            return true;
        });
    }
    /// Marks the pixels on both sides of those that are left; whether there are any.
    bool mark(Raster<std::uint8_t>& pixels) const {
        bool any = false;
        for (const auto& places : squares_) {
            for (const auto& at : places) {
                const auto column = static_cast<std::uint32_t>(at.x), row = static_cast<std::uint32_t>(at.y);
                const bool right = at.x == std::floor(at.x);
                pixels.at(column, row) = 1;
                pixels.at(right ? column - 1 : column, right ? row : row - 1) = 1;
                any = true;
            }
        }
        return any;
    }

  private:
    static constexpr std::uint32_t square = 4;  // pixels

    /// take(places of a square, number) for those within a distance of a line, until it says false.
    template <class Take>
    void eachBeside(const LinePoint& from, const LinePoint& to, double reach, const Take& take) {
        const glm::dvec2 least = (glm::min(from.at, to.at) - reach - 1.0) / double(square),
                         most = (glm::max(from.at, to.at) + reach) / double(square);
        const glm::dvec2 way = to.at - from.at;
        const double whole = glm::dot(way, way);
        const auto held = [](double at, std::uint32_t count) {
            return static_cast<std::uint32_t>(std::clamp(std::floor(at), 0.0, count - 1.0));
        };
        for (auto row = held(least.y, rows_); row <= held(most.y, rows_); ++row) {
            for (auto column = held(least.x, columns_); column <= held(most.x, columns_); ++column) {
                auto& places = squares_[std::size_t{row} * columns_ + column];
                for (std::size_t i = places.size(); i-- > 0;) {
                    const glm::dvec2 off = glm::dvec2(places[i]) - from.at;
                    const double share = whole > 0.0 ? std::clamp(glm::dot(off, way) / whole, 0.0, 1.0) : 0.0;
                    if (glm::length(off - share * way) <= reach && !take(places, i)) return;
                }
            }
        }
    }

    std::uint32_t columns_, rows_;
    std::vector<std::vector<glm::vec2>> squares_;  // places by where their pixels are
};

/// Finds what is missing of outer contours, and draws it.
class ContourMaker {
  public:
    ContourMaker(const Raster<Sight>& sight, const Raster<float>& depth, ChosenLines& chosen)
        : sight_(sight), depth_(depth), chosen_(chosen), inked_(depth.width, depth.height) {
        for (const auto& line : chosen_.lines) mark(line);
    }

    /// What is drawn more of a film's picture, as little as stands for all outer contours: what was drawn
    /// before stays anyway. Lines have places so near each other as finely() makes them.
    std::vector<InkLine> makeOfFilm(const std::stop_token& stop) {
        BareBorders bare(sight_);
        const auto coverAll = [&](const std::vector<InkLine>& lines) {
            for (const auto& line : lines) {
                giveWay();
                for (std::size_t i = 0; i + 1 < line.points.size(); ++i)
                    bare.cover(line.points[i], line.points[i + 1]);
            }
        };
        coverAll(chosen_.lines);
        const auto take = [&](const LinePoint& from, const LinePoint& to, double reach) {
            if (!bare.anyBeside(from, to, reach)) return false;
            bare.cover(from, to);
            return true;
        };
        for (const auto& [step, reach] :
             {std::pair(outerStep, contourNear), std::pair(outerStep, contourReach),
              std::pair(0.0F, contourReach)}) {
            if (isStopped(stop)) return std::move(more_);
            takeLeft([&, least = static_cast<double>(step), within = reach](const LinePoint& from,
                                                                            const LinePoint& to, auto...) {
                return from.step >= least && take(from, to, within);
            });
        }
        gaps_ = Raster<std::uint8_t>(sight_.width, sight_.height);
        if (bare.mark(gaps_) && !isStopped(stop)) drawBorders(stop);
        return std::move(more_);
    }
    /// What is drawn more. `carry`: by which those come first that were drawn before; or null.
    std::vector<InkLine> make(const Carry* carry, const std::stop_token& stop) {
        const auto isOuter = [&](const LinePoint& from, const LinePoint& to) {
            return from.step >= static_cast<double>(outerStep) && !isAlongInk(from, to);
        };
        const bool gaps = !sight_.values.empty() && findGaps();
        if (carry != nullptr) {
            const auto before = carry->linesBefore(chosen_.left);
            takeLeft([&](const LinePoint& from, const LinePoint& to, std::size_t line, std::size_t segment) {
                return before[line][segment] == LineBefore::drawn &&
                       (isOuter(from, to) || (gaps && isAtGap(from, to)));
            });
        }
        takeLeft([&](const LinePoint& from, const LinePoint& to, auto...) { return isOuter(from, to); });
        if (isStopped(stop) || !gaps) return std::move(more_);
        takeLeft([&](const LinePoint& from, const LinePoint& to, auto...) { return isAtGap(from, to); });
        if (!isStopped(stop) && findGaps()) drawBorders(stop);
        return std::move(more_);
    }

  private:
    template <class Take>
    void eachPixelOf(const LinePoint& from, const LinePoint& to, const Take& take) const {
        eachSquare(from.at, to.at, inked_.width, inked_.height,
                   [&](std::uint32_t column, std::uint32_t row, double) { take(column, row); });
    }
    void mark(const InkLine& line) {
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i)
            eachPixelOf(line.points[i], line.points[i + 1],
                        [&](std::uint32_t column, std::uint32_t row) { inked_.at(column, row) = 1; });
    }
    /// Whether a pixel or one of those around it is marked.
    static bool isNear(const Raster<std::uint8_t>& marks, std::uint32_t column, std::uint32_t row) {
        for (std::uint32_t y = row > 0 ? row - 1 : 0; y <= std::min(row + 1, marks.height - 1); ++y) {
            for (std::uint32_t x = column > 0 ? column - 1 : 0; x <= std::min(column + 1, marks.width - 1);
                 ++x) {
                if (marks.at(x, y) != 0) return true;
            }
        }
        return false;
    }
    bool isAlongInk(const LinePoint& from, const LinePoint& to) const {
        bool along = true;
        eachPixelOf(from, to, [&](std::uint32_t column, std::uint32_t row) {
            along = along && isNear(inked_, column, row);
        });
        return along;
    }
    bool isAtGap(const LinePoint& from, const LinePoint& to) const {
        bool any = false;
        eachPixelOf(from, to, [&](std::uint32_t column, std::uint32_t row) {
            for (std::uint32_t y = row > 0 ? row - 1 : 0; !any && y <= std::min(row + 1, gaps_.height - 1);
                 ++y) {
                for (std::uint32_t x = column > 0 ? column - 1 : 0;
                     x <= std::min(column + 1, gaps_.width - 1); ++x)
                    any = any || (gaps_.at(x, y) != 0 && !isNear(inked_, x, y));
            }
        });
        return any;
    }
    /// Draws those segments of lines that are left for which `wants` is true, one after another.
    template <class Wants>
    void takeLeft(const Wants& wants) {
        std::vector<InkLine> left;
        for (std::size_t number = 0; number < chosen_.left.size(); ++number) {
            const auto& line = chosen_.left[number];
            giveWay();
            bool taken = false;
            InkLine part{line.kind, {}, line.rank};
            const auto end = [&] {
                if (part.points.size() > 1) {
                    if (taken) mark(part);
                    (taken ? more_ : left).push_back(part);
                }
                part.points.clear();
            };
            for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
                const bool take = wants(line.points[i], line.points[i + 1], number, i);
                if (take != taken) end();
                taken = take;
                if (part.points.empty()) part.points.push_back(line.points[i]);
                part.points.push_back(line.points[i + 1]);
            }
            end();
        }
        chosen_.left = std::move(left);
    }
    /// Marks pixels on both sides of borders along which no line is drawn; whether there are any.
    bool findGaps() {
        gaps_ = Raster<std::uint8_t>(sight_.width, sight_.height);
        bool any = false;
        eachBorder(sight_, [&](std::uint32_t column, std::uint32_t row, bool right) {
            const std::uint32_t x = right ? column + 1 : column, y = right ? row : row + 1;
            if (isNear(inked_, column, row) && isNear(inked_, x, y)) return;
            gaps_.at(column, row) = gaps_.at(x, y) = 1;
            any = true;
        });
        return any;
    }
    /// Draws borders of what is seen where there are gaps.
    void drawBorders(const std::stop_token& stop) {
        Raster<float> seen(sight_.width, sight_.height);
        for (std::size_t i = 0; i < seen.values.size(); ++i)
            seen.values[i] = sight_.values[i] != Sight::nothing;
        for (const auto& outline : contoursOf(seen, 0.5F, stop)) {
            giveWay();
            drawBorder(rounded(outline.points));
        }
    }
    /// Places about a pixel apart, of which the corners of pixels are taken.
    static std::vector<glm::dvec2> rounded(const std::vector<glm::dvec2>& corners) {
        std::vector<glm::dvec2> places;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const auto &from = corners[i], &to = corners[(i + 1) % corners.size()];
            const auto parts = static_cast<int>(std::max(1.0, std::round(glm::distance(from, to))));
            for (int part = 0; part < parts; ++part)
                places.push_back(glm::mix(from, to, static_cast<double>(part) / parts));
        }
        for (int round = 0; round < borderRounds; ++round) {
            const auto before = places;
            const std::size_t count = places.size();
            for (std::size_t i = 0; i < count; ++i)
                places[i] =
                    0.5 * before[i] + 0.25 * (before[(i + count - 1) % count] + before[(i + 1) % count]);
        }
        return places;
    }
    void drawBorder(const std::vector<glm::dvec2>& places) {
        InkLine line;
        const auto end = [&] {
            if (line.points.size() > 1) {
                simplify(line.points);
                more_.push_back(line);
            }
            line.points.clear();
        };
        for (std::size_t i = 0; i <= places.size(); ++i) {
            const auto& at = places[i % places.size()];
            if (isWithin(at) &&
                isNear(gaps_, static_cast<std::uint32_t>(at.x), static_cast<std::uint32_t>(at.y)))
                line.points.push_back({at, nearestDepth(at), 1.0});
            else
                end();
        }
        end();
    }
    /// The picture's sides are no borders of what is seen.
    bool isWithin(const glm::dvec2& at) const {
        return at.x > 0.75 && at.y > 0.75 && at.x < sight_.width - 0.75 && at.y < sight_.height - 0.75;
    }
    double nearestDepth(const glm::dvec2& at) const {
        float nearest = HUGE_VALF;
        for (int down = -2; down <= 2; ++down) {
            for (int across = -2; across <= 2; ++across)
                nearest = std::min(nearest, depth_.near(at.x + across, at.y + down));
        }
        return std::isfinite(nearest) ? static_cast<double>(nearest) : 0.0;
    }

    static constexpr int borderRounds = 4;

    const Raster<Sight>& sight_;
    const Raster<float>& depth_;
    ChosenLines& chosen_;
    Raster<std::uint8_t> inked_, gaps_;  // pixels that lines pass; beside borders without lines
    std::vector<InkLine> more_;
};

/// What is drawn of lines, or is not; pieces that follow one another are one.
std::vector<InkLine> joined(const std::vector<InkLine>& lines, const std::vector<Piece>& pieces, bool drawn) {
    std::vector<InkLine> made;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        if (pieces[i].drawn != drawn) continue;
        const InkLine& line = lines[pieces[i].line];
        const std::size_t begin = pieces[i].begin;
        while (i + 1 < pieces.size() && pieces[i + 1].drawn == drawn && pieces[i + 1].line == pieces[i].line)
            ++i;
        made.push_back({line.kind,
                        {line.points.begin() + static_cast<std::ptrdiff_t>(begin),
                         line.points.begin() + static_cast<std::ptrdiff_t>(pieces[i].end) + 1}});
    }
    return made;
}

}  // namespace

ToneGrid densityOf(const std::vector<InkLine>& lines, const ToneCells& cells, double width) {
    ToneGrid grid(cells.columns, cells.rows);
    for (const auto& line : lines) {
        giveWay();
        eachDrop(line, 0, line.points.size() - 1, cells, width,
                 [&](const Drop& drop) { grid.at(drop.column, drop.row) += static_cast<float>(drop.cover); });
    }
    return blurred(grid, cells.blur);
}

ChosenLines chooseLines(const std::vector<InkLine>& all, const SilhouetteStyle& style,
                        const LineTarget& target, const std::stop_token& stop) {
    std::vector<InkLine> fine;
    if (target.isOfFilm()) fine = finely(all);
    const auto& lines = target.isOfFilm() ? fine : all;
    if (style.mode == SilhouetteMode::none)
        return {{}, lines, ToneGrid(target.cells.columns, target.cells.rows)};
    if (style.mode == SilhouetteMode::all) return {lines, {}, densityOf(lines, target.cells, target.width)};
    if (target.quick && style.mode == SilhouetteMode::adjusted) return thinned(lines, style, target);
    auto pieces = piecesOf(lines, target.longest, target.before);
    Trial trial(lines, target);
    if (style.mode == SilhouetteMode::adjusted) {
        adjust(pieces, lines, style, target, trial, stop);
    } else {
        for (auto& piece : pieces) {
            if (isImportant(piece.importance, style)) trial.draw(piece);
        }
    }
    return {joined(lines, pieces, true), joined(lines, pieces, false), trial.take()};
}

void makeContoursWhole(const Raster<Sight>& sight, const Raster<float>& depth, const LineTarget& target,
                       ChosenLines& chosen, const std::stop_token& stop) {
    ContourMaker maker(sight, depth, chosen);
    const bool film = target.isOfFilm() && !sight.values.empty();
    auto more = film ? maker.makeOfFilm(stop) : maker.make(target.before, stop);
    if (more.empty()) return;
    const auto density = densityOf(more, target.cells, target.width);
    for (std::size_t i = 0; i < density.values.size(); ++i) chosen.density.values[i] += density.values[i];
    std::move(more.begin(), more.end(), std::back_inserter(chosen.lines));
}

}  // namespace mote::render
