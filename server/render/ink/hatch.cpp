// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/hatch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>
#include <limits>

#include "server/render/ink/tone_grid.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

// Of the spacing: from a stroke to where another one is sought.
constexpr std::array seeksAt{1.0, 0.8};
// Of the density from which on strokes are drawn: they end below a little less.
constexpr double endsFrom = 0.92;
// Of the spacing: from a stroke to where a new one begins, at least; to where it ends. Of the density from
// which on strokes are drawn: where they begin, from a little more on.
struct NewStrokes {
    double beginsAt, endsAt, beginsFrom;
};
constexpr NewStrokes ofPictures{0.8, 0.6, 1.06};
// Where strokes stay, which others would not so near each other: so much farther off that there is no more
// ink.
constexpr NewStrokes besideThoseThatStay{0.95, 0.7, 1.12};
// Of strokes of before, which stay where others would not: to other strokes, the density, and of the length
// that others have at least; cosine of what they may be off their direction.
constexpr double staysAt = 0.5, staysFrom = 0.88, staysLong = 0.4, mostOff = 0.7;
constexpr double leastStraight = 0.7;  // cosine of what a stroke turns by at a place
constexpr double sameWay = 0.5;        // likewise, of cells beside each other whose directions are one
constexpr std::size_t mostSteps = 16384;
constexpr double hatchTolerance = 0.1;  // pixels that a stroke may be off its way
constexpr std::size_t longestHatchRun = 24;
constexpr double fullCover = 0.98;

/// Places of strokes, found by where they are; the last ones can be taken back.
class StrokePlaces {
  public:
    /// `spacing`: of strokes, pixels; no search goes farther.
    StrokePlaces(double spacing, const glm::dvec2& size)
        : spacing_(spacing),
          reach_(std::max(spacing, 2.0)),
          columns_(static_cast<std::size_t>(size.x / reach_) + 1),
          heads_(columns_ * (static_cast<std::size_t>(size.y / reach_) + 1), none) {}

    /// `along`: of the stroke, pixels.
    void add(const glm::dvec2& at, std::uint32_t stroke, double along) {
        const glm::vec2 place(at);
        auto& head = heads_[cellOf(place)];
        places_.push_back({place, static_cast<float>(along), stroke, head});
        head = static_cast<std::uint32_t>(places_.size() - 1);
    }
    std::size_t size() const { return places_.size(); }
    void takeBack(std::size_t size) {
        for (; places_.size() > size; places_.pop_back())
            heads_[cellOf(places_.back().at)] = places_.back().next;
    }
    /// Whether no place is nearer; of the stroke's own, none that is no neighbour along it.
    bool isFree(const glm::dvec2& at, double distance, std::uint32_t stroke, double along) const {
        const auto column = static_cast<std::size_t>(at.x / reach_),
                   row = static_cast<std::size_t>(at.y / reach_);
        const std::size_t rows = heads_.size() / columns_;
        const auto square = static_cast<float>(distance * distance);
        const glm::vec2 place(at);
        for (std::size_t y = row > 0 ? row - 1 : 0; y <= std::min(row + 1, rows - 1); ++y) {
            for (std::size_t x = column > 0 ? column - 1 : 0; x <= std::min(column + 1, columns_ - 1); ++x) {
                for (auto i = heads_[y * columns_ + x]; i != none; i = places_[i].next) {
                    const auto& one = places_[i];
                    const glm::vec2 off = one.at - place;
                    if (off.x * off.x + off.y * off.y >= square) continue;
                    if (one.stroke == stroke &&
                        std::abs(static_cast<double>(one.along) - along) < 2.0 * spacing_)
                        continue;
                    return false;
                }
            }
        }
        return true;
    }

  private:
    static constexpr std::uint32_t none = UINT32_MAX;
    struct Place {
        glm::vec2 at;
        float along;
        std::uint32_t stroke, next;
    };

    /// Of a place as it is kept: as it was given it may lie in another cell.
    std::size_t cellOf(const glm::vec2& at) const {
        return static_cast<std::size_t>(static_cast<double>(at.y) / reach_) * columns_ +
               static_cast<std::size_t>(static_cast<double>(at.x) / reach_);
    }

    double spacing_, reach_;
    std::size_t columns_;
    std::vector<std::uint32_t> heads_;
    std::vector<Place> places_;
};

/// Leaves out points that lie on the way between others.
std::vector<glm::dvec2> straightened(const std::vector<glm::dvec2>& points) {
    std::vector<glm::dvec2> kept{points.front()};
    std::size_t anchor = 0;
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
        const glm::dvec2 way = points[i + 1] - points[anchor];
        const double length = glm::length(way);
        bool needed = i + 1 - anchor > longestHatchRun || !(length > 0.0);
        for (std::size_t k = anchor + 1; !needed && k <= i; ++k) {
            const glm::dvec2 off = points[k] - points[anchor];
            needed = std::abs(way.x * off.y - way.y * off.x) > hatchTolerance * length;
        }
        if (!needed) continue;
        kept.push_back(points[i]);
        anchor = i;
    }
    kept.push_back(points.back());
    return kept;
}

/// Draws the strokes of one direction; one thread's.
class StrokeMaker {
  public:
    StrokeMaker(const HatchScene& scene, const HatchOptions& options, bool second,
                const std::stop_token& stop)
        : scene_(scene),
          options_(options),
          second_(second),
          stop_(stop),
          size_(scene.density.width, scene.density.height) {}

    void make(const std::vector<HatchPass>& passes, const std::vector<HatchStroke>& before) {
        float most = 0.0F;
        for (const float density : scene_.density.values) most = std::max(most, density);
        for (std::uint32_t number = 0; number < passes.size() && !isStopped(stop_); ++number) {
            pass_ = passes[number];
            number_ = number;
            if (pass_.second == second_ && static_cast<double>(most) > pass_.from) makePass(before);
        }
    }
    std::vector<HatchStroke> take() { return std::move(strokes_); }

  private:
    void makePass(const std::vector<HatchStroke>& before) {
        step_ = std::clamp(0.4 * std::min(options_.spacing, pass_.spacing), 0.75, 4.0);
        places_ = StrokePlaces(pass_.spacing, size_);
        for (std::uint32_t i = 0; i < strokes_.size(); ++i) addPlaces(ways_[i], i);
        from_ = pass_.from;
        for (const auto& stroke : before) {
            giveWay();
            if (stroke.pass == number_) keep(stroke);
        }
        new_ = newStrokes();
        for (const auto& run : runs_) grow(run);
        runs_.clear();
        std::size_t next = 0;
        seekBesideAll(next);
        const auto stride = std::max(1.0, 0.5 * pass_.spacing);
        const auto middle = [&](int cell) { return (cell + 0.5) * stride; };
        for (int row = 0; middle(row) < size_.y && !isStopped(stop_); ++row) {
            giveWay();
            for (int column = 0; middle(column) < size_.x; ++column) {
                from_ = pass_.to;
                if (begin({middle(column), middle(row)})) seekBesideAll(next);
            }
        }
    }
    void seekBesideAll(std::size_t& next) {
        for (; next < ways_.size() && !isStopped(stop_); ++next) {
            giveWay();
            const auto every =
                std::max<std::size_t>(1, static_cast<std::size_t>(0.5 * pass_.spacing / step_));
            for (std::size_t i = 0; i < ways_[next].size(); i += every) seekBeside(next, i);
        }
    }
    void seekBeside(std::size_t stroke, std::size_t i) {
        const glm::dvec2 at(ways_[stroke][i]);
        const glm::dvec2 along = wayAt(ways_[stroke], i);
        const glm::dvec2 across(-along.y, along.x);
        for (const double side : {-1.0, 1.0}) {
            from_ = densityOf(
                std::lerp(coverOf(pass_.from), coverOf(pass_.to), rankOf(2 * stroke + (side > 0.0 ? 1 : 0))));
            for (const double share : seeksAt) {
                if (begin(at + side * share * pass_.spacing * across)) break;
            }
        }
    }
    /// From 0 to 1, as even as can be over numbers that follow one another (van der Corput 1935). A stroke
    /// between two others is begun from both: so that the lesser of two such ranks is even.
    static double rankOf(std::size_t number) {
        double rank = 0.0, share = 0.5;
        for (; number > 0; number /= 2, share *= 0.5) rank += number % 2 == 1 ? share : 0.0;
        return 1.0 - (1.0 - rank) * (1.0 - rank);
    }
    template <class Place>
    static glm::dvec2 wayAt(const std::vector<Place>& way, std::size_t i) {
        const glm::dvec2 along(way[std::min(i + 1, way.size() - 1)] - way[i > 0 ? i - 1 : 0]);
        const double length = glm::length(along);
        return length > 0.0 ? along / length : glm::dvec2(1.0, 0.0);
    }

    bool isInside(const glm::dvec2& at) const {
        return at.x >= 0.0 && at.y >= 0.0 && at.x < size_.x && at.y < size_.y;
    }
    bool isWanted(const glm::dvec2& at, double share) const {
        return static_cast<double>(scene_.density.at(static_cast<std::uint32_t>(at.x),
                                                     static_cast<std::uint32_t>(at.y))) > share * from_;
    }
    bool goesOn(const glm::dvec2& from, const glm::dvec2& to) const {
        return scene_.goesOn(static_cast<std::uint32_t>(from.x), static_cast<std::uint32_t>(from.y),
                             static_cast<std::uint32_t>(to.x), static_cast<std::uint32_t>(to.y));
    }
    const HatchField::Cell& cellAt(const glm::dvec2& at) const {
        return scene_.field.cells.near(at.x / scene_.field.pixels, at.y / scene_.field.pixels);
    }
    /// This maker's direction at a place; zero if there is none.
    glm::dvec2 own(const glm::dvec2& at) const {
        const auto& cell = cellAt(at);
        return glm::dvec2(second_ ? cell.second : cell.first);
    }
    /// The same between cells of one surface, the way that is nearest to `heading`; zero where strokes of
    /// these cells go elsewhere.
    glm::dvec2 directionAt(const glm::dvec2& at, const glm::dvec2& heading) const {
        const auto& cells = scene_.field.cells;
        const double x = at.x / scene_.field.pixels - 0.5, y = at.y / scene_.field.pixels - 0.5;
        const double left = std::floor(x), top = std::floor(y), u = x - left, v = y - top;
        const bool homeRight = u >= 0.5, homeBelow = v >= 0.5;
        glm::dvec2 sum(0.0);
        for (const bool below : {false, true}) {
            for (const bool right : {false, true}) {
                const double column = left + right, row = top + below;
                if (!(column >= 0.0 && row >= 0.0 && column < cells.width && row < cells.height)) continue;
                const auto& cell =
                    cells.at(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row));
                if (cell.first == glm::vec2(0.0F)) continue;
                if ((right != homeRight || below != homeBelow) &&
                    !connected(static_cast<std::uint32_t>(std::max(left, 0.0)),
                               static_cast<std::uint32_t>(std::max(top, 0.0)), right != homeRight,
                               below != homeBelow, homeRight, homeBelow))
                    continue;
                const double weight = (right ? u : 1.0 - u) * (below ? v : 1.0 - v);
                const glm::dvec2 arm(second_ ? cell.second : cell.first);
                const double cosine = glm::dot(arm, heading);
                if (std::abs(cosine) >= sameWay) sum += (cosine < 0.0 ? -weight : weight) * arm;
            }
        }
        const double length = glm::length(sum);
        return length > 0.0 ? sum / length : glm::dvec2(0.0);
    }
    /// Whether from a cell of four one surface goes on to another: beside it by `across`, above or below by
    /// `down`. `column`, `row`: of the upper left one.
    bool connected(std::uint32_t column, std::uint32_t row, bool across, bool down, bool homeRight,
                   bool homeBelow) const {
        const auto& cells = scene_.field.cells;
        const auto right = [&](bool below) {
            return cells.at(column, std::min(row + (below ? 1U : 0U), cells.height - 1)).right;
        };
        const auto under = [&](bool atRight) {
            return cells.at(std::min(column + (atRight ? 1U : 0U), cells.width - 1), row).below;
        };
        if (across && down)
            return (right(homeBelow) && under(!homeRight)) || (under(homeRight) && right(!homeBelow));
        return across ? right(homeBelow) : under(homeRight);
    }

    /// Begins a stroke through a place; whether it is one.
    bool begin(const glm::dvec2& at) {
        if (!isInside(at) || !isWanted(at, new_.beginsFrom)) return false;
        const auto stroke = static_cast<std::uint32_t>(strokes_.size());
        if (!places_.isFree(at, new_.beginsAt * pass_.spacing, stroke, 0.0)) return false;
        const glm::dvec2 way = directionAt(at, own(at));
        if (way == glm::dvec2(0.0)) return false;
        const auto kept = places_.size();
        places_.add(at, stroke, 0.0);
        std::vector<glm::dvec2> points = trace(at, -way, stroke, 0.0, -1.0);
        std::reverse(points.begin(), points.end());
        points.push_back(at);
        const auto more = trace(at, way, stroke, 0.0, 1.0);
        points.insert(points.end(), more.begin(), more.end());
        if (static_cast<double>(points.size() - 1) * step_ < options_.shortest()) {
            places_.takeBack(kept);
            return false;
        }
        put(points);
        return true;
    }
    /// Places step by step from one on, without it. `along`: of the stroke up to there.
    std::vector<glm::dvec2> trace(glm::dvec2 at, glm::dvec2 heading, std::uint32_t stroke, double along,
                                  double side) {
        std::vector<glm::dvec2> points;
        double marked = along;
        while (points.size() < mostSteps) {
            const glm::dvec2 half = directionAt(at, heading);
            if (half == glm::dvec2(0.0)) break;
            const glm::dvec2 middle = at + 0.5 * step_ * half;
            if (!isInside(middle)) break;
            const glm::dvec2 way = directionAt(middle, half);
            if (way == glm::dvec2(0.0) || glm::dot(way, heading) < leastStraight) break;
            const glm::dvec2 to = at + step_ * way;
            along += side * step_;
            if (!isInside(to) || !isWanted(to, endsFrom) || !goesOn(at, to) ||
                !places_.isFree(to, new_.endsAt * pass_.spacing, stroke, along))
                break;
            points.push_back(to);
            if (std::abs(along - marked) >= 0.35 * pass_.spacing) {
                places_.add(to, stroke, along);
                marked = along;
            }
            at = to;
            heading = way;
        }
        return points;
    }
    void put(const std::vector<glm::dvec2>& way) {
        strokes_.push_back({straightened(way), number_, second_});
        ways_.emplace_back(way.begin(), way.end());
    }
    void addPlaces(const std::vector<glm::vec2>& way, std::uint32_t stroke) {
        for (std::size_t i = 0; i + 1 < way.size(); ++i) {
            const glm::dvec2 from(way[i]), to(way[i + 1]);
            const auto parts = static_cast<int>(std::ceil(glm::distance(from, to) / (0.5 * pass_.spacing)));
            for (int part = 0; part < parts; ++part)
                places_.add(glm::mix(from, to, static_cast<double>(part) / parts), stroke, 0.0);
        }
    }

    /// The more of a pass stays, the farther off are new strokes.
    NewStrokes newStrokes() const {
        if (runs_.empty()) return ofPictures;
        double kept = 0.0, dark = 0.0;
        for (const auto& run : runs_) kept += static_cast<double>(run.size()) * step_;
        for (const float density : scene_.density.values)
            dark += static_cast<double>(density) > pass_.from ? 1.0 : 0.0;
        // Strokes of a pass lie between those of earlier ones.
        const double apart = strokes_.empty() ? pass_.spacing : 2.0 * pass_.spacing;
        const double share = std::min(1.0, kept * apart / std::max(dark, 1.0));
        const auto& [beginsAt, endsAt, beginsFrom] = besideThoseThatStay;
        return {std::lerp(ofPictures.beginsAt, beginsAt, share), std::lerp(ofPictures.endsAt, endsAt, share),
                std::lerp(ofPictures.beginsFrom, beginsFrom, share)};
    }
    /// All runs stay before the first of them goes on at both ends, which would take the places of others.
    void grow(const std::vector<glm::dvec2>& run) {
        const auto number = static_cast<std::uint32_t>(strokes_.size());
        const double along = static_cast<double>(run.size() - 1) * step_;
        auto front = trace(run.front(), -wayAt(run, 0), number, 0.0, -1.0);
        const auto back = trace(run.back(), wayAt(run, run.size() - 1), number, along, 1.0);
        std::reverse(front.begin(), front.end());
        front.insert(front.end(), run.begin(), run.end());
        front.insert(front.end(), back.begin(), back.end());
        put(front);
    }
    /// What of a stroke of before still is where it may be.
    void keep(const HatchStroke& stroke) {
        std::vector<glm::dvec2> run;
        auto kept = places_.size();
        const auto end = [&] {
            if (static_cast<double>(run.size()) * step_ >= staysLong * options_.shortest()) {
                runs_.push_back(run);
            } else {
                places_.takeBack(kept);
            }
            run.clear();
            kept = places_.size();
        };
        for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
            const glm::dvec2 from = stroke.points[i], to = stroke.points[i + 1];
            const double length = glm::distance(from, to);
            if (!(length > 0.0 && length < 64.0 * step_ * static_cast<double>(longestHatchRun))) {
                end();
                continue;
            }
            const glm::dvec2 heading = (to - from) / length;
            const auto parts = static_cast<std::size_t>(std::max(1.0, std::round(length / step_)));
            for (std::size_t part = 0; part < parts; ++part) {
                const glm::dvec2 at =
                    glm::mix(from, to, static_cast<double>(part) / static_cast<double>(parts));
                const auto number = static_cast<std::uint32_t>(strokes_.size() + runs_.size());
                const double along = static_cast<double>(run.size()) * step_;
                const bool stays = isInside(at) && isWanted(at, staysFrom) &&
                                   glm::dot(directionAt(at, heading), heading) >= mostOff &&
                                   (run.empty() || goesOn(run.back(), at)) &&
                                   places_.isFree(at, staysAt * pass_.spacing, number, along);
                if (!stays) {
                    end();
                    continue;
                }
                if (run.size() % 2 == 0) places_.add(at, number, along);
                run.push_back(at);
            }
        }
        end();
    }

    const HatchScene& scene_;
    const HatchOptions& options_;
    const bool second_;
    const std::stop_token& stop_;
    const glm::dvec2 size_;
    double step_ = 1.0;  // pixels along a stroke
    HatchPass pass_{};
    NewStrokes new_ = ofPictures;
    std::uint32_t number_ = 0;  // of the pass
    double from_ = 0.0;         // density from which on the stroke is drawn that is made
    StrokePlaces places_{1.0, glm::dvec2(1.0)};
    std::vector<HatchStroke> strokes_;
    std::vector<std::vector<glm::dvec2>> runs_;  // of strokes of before, step by step, that stay
    std::vector<std::vector<glm::vec2>> ways_;   // of strokes, step by step
};

}  // namespace

std::vector<HatchPass> hatchPasses(const HatchOptions& options) {
    struct Layer {
        bool second;
        double spacing;  // of strokes with those that were there before
        double before;   // likewise, that there was; none: infinity
    };
    const double s = options.spacing;
    constexpr double none = std::numeric_limits<double>::infinity();
    const std::array layers{
        Layer{false, 4.0 * s, none}, Layer{false, 2.0 * s, 4.0 * s}, Layer{false, s, 2.0 * s},
        Layer{true, 4.0 * s, none},  Layer{true, 2.0 * s, 4.0 * s},  Layer{true, s, 2.0 * s},
        Layer{false, 0.5 * s, s},    Layer{true, 0.5 * s, s},        Layer{false, 0.25 * s, 0.5 * s}};
    const auto coverBy = [&](double spacing) { return std::min(options.width / spacing, fullCover); };
    std::vector<HatchPass> passes;
    double bare = 1.0;
    for (const auto& layer : layers) {
        const double left = bare * (1.0 - coverBy(layer.spacing)) / (1.0 - coverBy(layer.before));
        // Where lines cover all there is no room for more.
        if (!(left < bare)) continue;
        const double middle = -std::log(0.5 * (bare + left)), reached = -std::log(left);
        // Few strokes far apart come and go at once, those that double others one by one.
        if (layer.spacing < s)
            passes.push_back({layer.second, layer.spacing, -std::log(bare), reached, reached});
        else
            passes.push_back({layer.second, layer.spacing, middle, middle, reached});
        bare = left;
    }
    return passes;
}

std::vector<HatchStroke> hatch(const HatchScene& scene, const std::vector<HatchStroke>& before,
                               const HatchOptions& options, const std::stop_token& stop) {
    if (scene.density.values.empty() || scene.field.cells.values.empty()) return {};
    const auto passes = hatchPasses(options);
    StrokeMaker first(scene, options, false, stop), second(scene, options, true, stop);
    bothInTurns([&] { first.make(passes, before); }, [&] { second.make(passes, before); });
    auto strokes = first.take(), more = second.take();
    if (isStopped(stop)) return {};
    std::move(more.begin(), more.end(), std::back_inserter(strokes));
    std::stable_sort(strokes.begin(), strokes.end(),
                     [](const HatchStroke& a, const HatchStroke& b) { return a.pass < b.pass; });
    return strokes;
}

}  // namespace mote::render
