// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ink/hatch_field.h"

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <numbers>
#include <queue>
#include <tuple>

#include "server/render/ink/tone_grid.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

using Complex = std::complex<float>;
using Place = ContinuousSight::Place;

// One surface goes on from place to place:
constexpr double leastBend = 0.7;      // cosine of what normals are apart by, at least
constexpr double mostRise = 0.5;       // of the way between them, out of either's tangent plane, at most
constexpr double mostDepthStep = 0.1;  // of the extent, between two cells
constexpr double alikeDepths = 5e-4;   // of the extent: pixels that are surely one surface
constexpr float alikeAngles = 0.2F, alikeAcross = 0.1F;

constexpr int fitted = 4, fitEvery = 2;  // cells on each side of one by which its curvature is told
constexpr double certain =
    0.25;  // radians that a surface turns by more one way than the other, to count half
// Curvature around counts by so much where a cell's own says little, over so many cells.
constexpr std::array<std::array<float, 2>, 2> bendAround{{{3.0F, 1.0F}, {10.0F, 0.3F}}};
// Where the way around the form is so clear, over so many cells, first strokes go there.
constexpr float aroundFrom = 0.25F, aroundOver = 5.0F;
constexpr float regionCounts = 0.02F, beforeCounts = 0.1F;
constexpr double leastAgreement = 0.1;  // of directions in a region that has one
constexpr double withoutDirection = 0.25 * std::numbers::pi;

/// The tangent plane's axes at a normal, turned from those of the screen the shortest way (Frisvad 2012,
/// Building an Orthonormal Basis from a 3D Unit Vector Without Normalization): so a direction in it has much
/// the same angle at places near each other.
struct TangentAxes {
    glm::dvec3 u, v;

    explicit TangentAxes(const glm::dvec3& n) {
        const double a = -1.0 / (1.0 + std::max(n.z, -0.9)), b = n.x * n.y * a;
        u = {1.0 + n.x * n.x * a, b, -n.x};
        v = {b, 1.0 + n.y * n.y * a, -n.y};
    }
};

/// How a step from a place in eye space looks on the screen, but for its length.
glm::dvec2 seenStep(const InkCamera& camera, const glm::dvec3& at, const glm::dvec3& step) {
    if (!camera.perspective) return {step.x, -step.y};
    return {-step.x * at.z + at.x * step.z, step.y * at.z - at.y * step.z};
}

/// Mean directions of regions, which have no sign (of doubled angles: Mardia 1972).
std::vector<double> meanDirections(const Modalities& modalities, const Segments& regions) {
    std::vector<glm::dvec2> sums(regions.count, glm::dvec2(0.0));
    std::vector<double> counts(regions.count);
    for (std::size_t i = 0; i < regions.label.values.size(); ++i) {
        if (i % regions.label.width == 0) giveWay();
        const auto label = regions.label.values[i];
        const auto angle = static_cast<double>(modalities.angle.values[i]);
        if (label >= regions.count || angle == 0.0 || !std::isfinite(angle)) continue;
        sums[label] += glm::dvec2(std::cos(2.0 * angle), std::sin(2.0 * angle));
        counts[label] += 1.0;
    }
    std::vector<double> directions(regions.count, withoutDirection);
    for (std::uint32_t i = 0; i < regions.count; ++i) {
        if (glm::length(sums[i]) > leastAgreement * counts[i])
            directions[i] = 0.5 * std::atan2(sums[i].y, sums[i].x);
    }
    return directions;
}

/// Finds a symmetric matrix by which normals change from place to place, the shape operator, by least
/// squares (after Rusinkiewicz 2004, Estimating Curvatures and Their Derivatives on Triangle Meshes).
class ShapeFit {
  public:
    void add(const glm::dvec2& way, const glm::dvec2& turn) {
        xx_ += way.x * way.x;
        xy_ += way.x * way.y;
        yy_ += way.y * way.y;
        a_ += way.x * turn.x;
        b_ += way.y * turn.x + way.x * turn.y;
        c_ += way.y * turn.y;
        turns_ += glm::dot(turn, turn);
        ++count_;
    }
    /// The greater curvature's direction, with a length by how much it exceeds the other, 1 by world unit;
    /// doubled angle. `trust`: 0 to 1, by how well it tells what was added. `mean`: of both curvatures.
    std::complex<double> anisotropy(double& trust, double& mean) const {
        trust = mean = 0.0;
        if (count_ < 4) return {};
        // Of [xx xy 0; xy xx+yy xy; 0 xy yy] (a b c) = (a_ b_ c_).
        const double sum = xx_ + yy_, square = xx_ * yy_ - xy_ * xy_;
        const double determinant = sum * square;
        if (!(determinant > 1e-9 * sum * sum * sum)) return {};
        const double b = (b_ * xx_ * yy_ - xy_ * (a_ * yy_ + c_ * xx_)) / determinant;
        const double a = (a_ - xy_ * b) / xx_, c = (c_ - xy_ * b) / yy_;
        const double told = a * a_ + b * b_ + c * c_;
        mean = 0.5 * (a + c);
        trust = turns_ > 0.0 ? std::clamp(2.0 * told / turns_ - 1.0, 0.0, 1.0) : 0.0;
        return {a - c, 2.0 * b};
    }

  private:
    double xx_ = 0.0, xy_ = 0.0, yy_ = 0.0, a_ = 0.0, b_ = 0.0, c_ = 0.0, turns_ = 0.0;
    int count_ = 0;
};

/// Makes one field.
class FieldMaker {
  public:
    FieldMaker(const Modalities& modalities, const InkCamera& camera, const Segments& regions,
               const FieldOptions& options, const std::stop_token& stop)
        : modalities_(modalities),
          camera_(camera),
          regions_(regions),
          options_(options),
          stop_(stop),
          sight_(modalities, camera),
          columns_((modalities.depth.width + options.pixels - 1) / options.pixels),
          rows_((modalities.depth.height + options.pixels - 1) / options.pixels),
          places_(columns_, rows_),
          cross_(columns_, rows_),
          around_(columns_, rows_),
          field_{options.pixels, Raster<HatchField::Cell>(columns_, rows_)} {}

    HatchField make(const std::vector<HatchStroke>& before) {
        eachRow([&](std::uint32_t row) { look(row); });
        eachRow([&](std::uint32_t row) { connect(row); });
        eachRow([&](std::uint32_t row) { bend(row); });
        spread();
        follow(before);
        followRegions();
        eachRow([&](std::uint32_t row) { setArms(row); });
        comb();
        return std::move(field_);
    }

  private:
    template <class Take>
    void eachRow(const Take& take) const {
        forInTurns(std::uint32_t{0}, rows_, [&](std::uint32_t row) {
            if (!isStopped(stop_)) take(row);
        });
    }

    /// The pixel of a cell that sees something and is nearest to its middle.
    std::optional<glm::uvec2> middleOf(std::uint32_t column, std::uint32_t row) const {
        const std::uint32_t side = options_.pixels, left = column * side, top = row * side;
        std::optional<glm::uvec2> middle;
        int least = INT_MAX;
        for (std::uint32_t y = top; y < std::min(top + side, modalities_.depth.height); ++y) {
            for (std::uint32_t x = left; x < std::min(left + side, modalities_.depth.width); ++x) {
                if (!std::isfinite(modalities_.depth.at(x, y))) continue;
                const int dx = static_cast<int>(2 * (x - left) + 1 - side),
                          dy = static_cast<int>(2 * (y - top) + 1 - side);
                if (dx * dx + dy * dy >= least) continue;
                least = dx * dx + dy * dy;
                middle = {x, y};
            }
        }
        return middle;
    }
    /// What is seen in each cell: of what goes on around its middle, the mean.
    void look(std::uint32_t row) {
        const std::uint32_t side = options_.pixels, step = side >= 4 ? 2 : 1;
        for (std::uint32_t column = 0; column < columns_; ++column) {
            const auto middle = middleOf(column, row);
            if (!middle) continue;
            Place place = sight_.placeOf(middle->x, middle->y);
            if (!place.isSeen()) continue;
            const auto own = modalities_.depth.index(middle->x, middle->y);
            glm::dvec3 at = place.at, normal = place.normal;
            double count = 1.0;
            for (std::uint32_t y = row * side; y < std::min((row + 1) * side, modalities_.depth.height);
                 y += step) {
                for (std::uint32_t x = column * side;
                     x < std::min((column + 1) * side, modalities_.depth.width); x += step) {
                    if (x == middle->x && y == middle->y) continue;
                    const auto other = sight_.placeOf(x, y);
                    if (!other.isSeen() ||
                        !(sight_.alike(own, modalities_.depth.index(x, y)) || sight_.goesOn(place, other)))
                        continue;
                    at += other.at;
                    normal += other.normal;
                    count += 1.0;
                }
            }
            place.at = at / count;
            place.normal = glm::normalize(normal);
            places_.at(column, row) = place;
        }
    }
    void connect(std::uint32_t row) {
        for (std::uint32_t column = 0; column < columns_; ++column) {
            auto& cell = field_.cells.at(column, row);
            const auto& own = places_.at(column, row);
            cell.right = column + 1 < columns_ && sight_.goesOn(own, places_.at(column + 1, row));
            cell.below = row + 1 < rows_ && sight_.goesOn(own, places_.at(column, row + 1));
        }
    }
    /// How the surface bends in each cell.
    void bend(std::uint32_t row) {
        for (std::uint32_t column = 0; column < columns_; ++column) {
            const auto& own = places_.at(column, row);
            if (!own.isSeen()) continue;
            const TangentAxes axes(own.normal);
            ShapeFit fit;
            for (int down = -fitted; down <= fitted; down += fitEvery) {
                for (int across = -fitted; across <= fitted; across += fitEvery) {
                    const auto x = static_cast<int>(column) + across, y = static_cast<int>(row) + down;
                    if (x < 0 || y < 0 || x >= static_cast<int>(columns_) || y >= static_cast<int>(rows_))
                        continue;
                    const auto& other =
                        places_.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
                    if ((across == 0 && down == 0) || !sight_.goesOn(own, other)) continue;
                    const glm::dvec3 way = other.at - own.at, turn = other.normal - own.normal;
                    fit.add({glm::dot(way, axes.u), glm::dot(way, axes.v)},
                            {glm::dot(turn, axes.u), glm::dot(turn, axes.v)});
                }
            }
            double trust = 0.0, mean = 0.0;
            const auto twice = fit.anisotropy(trust, mean);
            const double pixel = (camera_.perspective ? -own.at.z : 1.0) / camera_.pixels;
            const double turn = std::abs(twice) * options_.length * pixel / certain;
            const auto counts = static_cast<float>(trust * turn * turn / (1.0 + turn * turn));
            if (!(counts > 0.0F)) continue;
            const std::complex<double> unit = twice / std::abs(twice);
            cross_.at(column, row) = counts * Complex(unit * unit);
            // The way in which it bends more, either way.
            const double more =
                std::min(std::abs(twice), 2.0 * std::abs(mean)) * options_.length * pixel / certain;
            around_.at(column, row) = static_cast<float>(trust * more * more / (1.0 + more * more)) *
                                      Complex(mean < 0.0 ? -unit : unit);
        }
    }

    /// Where a cell's own bend says little, that of the surface around it counts.
    void spread() {
        auto sum = cross_;
        for (const auto& [cells, counts] : bendAround) {
            const auto even = blurredOver(cross_, cells);
            for (std::size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += counts * even.values[i];
        }
        cross_ = std::move(sum);
        around_ = blurredOver(around_, aroundOver);
    }
    /// About a Gaussian's, along cells that one surface goes on between (Gastal and Oliveira 2011, as
    /// blurredWithin).
    Raster<Complex> blurredOver(const Raster<Complex>& crosses, float deviation) const {
        auto made = crosses;
        constexpr int passes = 2;
        for (int pass = 0; pass < passes; ++pass) {
            const double share =
                std::sqrt(3.0) * std::pow(2.0, passes - pass - 1) / std::sqrt(std::pow(4.0, passes) - 1.0);
            const auto keep =
                static_cast<float>(std::exp(-std::sqrt(2.0) / (static_cast<double>(deviation) * share)));
            const auto mix = [&](std::size_t from, std::size_t to, bool connected) {
                if (connected) made.values[to] += keep * (made.values[from] - made.values[to]);
            };
            const auto& cells = field_.cells.values;
            eachRow([&](std::uint32_t row) {
                const std::size_t first = made.index(0, row), last = first + columns_ - 1;
                for (std::size_t i = first; i < last; ++i) mix(i, i + 1, cells[i].right);
                for (std::size_t i = last; i > first; --i) mix(i, i - 1, cells[i - 1].right);
            });
            for (std::size_t i = 0; i + columns_ < made.values.size(); ++i)
                mix(i, i + columns_, cells[i].below);
            for (std::size_t i = made.values.size(); i-- > columns_;)
                mix(i, i - columns_, cells[i - columns_].below);
            giveWay();
        }
        return made;
    }

    /// A direction on the screen in a cell's tangent plane, as a unit number of its doubled angle; or 0.
    Complex doubled(std::uint32_t column, std::uint32_t row, const glm::dvec2& direction) const {
        const auto& place = places_.at(column, row);
        if (!place.isSeen()) return {};
        const TangentAxes axes(place.normal);
        const glm::dvec2 u = seenStep(camera_, place.at, axes.u), v = seenStep(camera_, place.at, axes.v);
        const double x = direction.x * v.y - direction.y * v.x, y = u.x * direction.y - u.y * direction.x;
        const double length = std::hypot(x, y);
        if (!(length > 0.0) || !std::isfinite(length)) return {};
        const Complex once(static_cast<float>(x / length), static_cast<float>(y / length));
        return once * once;
    }
    void follow(const std::vector<HatchStroke>& before) {
        for (const auto& stroke : before) {
            giveWay();
            for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
                const glm::dvec2 from = stroke.points[i] / double(options_.pixels),
                                 to = stroke.points[i + 1] / double(options_.pixels);
                eachSquare(from, to, columns_, rows_,
                           [&](std::uint32_t column, std::uint32_t row, double length) {
                               if (!(length > 0.0)) return;
                               const Complex way = doubled(column, row, to - from);
                               cross_.at(column, row) += beforeCounts * way * way;
                               around_.at(column, row) = stroke.second ? -way : way;
                           });
            }
        }
    }
    void followRegions() {
        if (regions_.label.values.empty()) return;
        const auto directions = meanDirections(modalities_, regions_);
        eachRow([&](std::uint32_t row) {
            for (std::uint32_t column = 0; column < columns_; ++column) {
                const auto middle = places_.at(column, row).isSeen() ? middleOf(column, row) : std::nullopt;
                if (!middle) continue;
                const auto label = regions_.label.at(middle->x, middle->y);
                if (label >= regions_.count) continue;
                const auto said =
                    label < regions_.directions.size() ? regions_.directions[label] : std::nullopt;
                const double angle = said.value_or(directions[label]);
                const Complex way = doubled(column, row, {std::cos(angle), std::sin(angle)});
                if (said && way != Complex()) {
                    cross_.at(column, row) = way * way;
                    around_.at(column, row) = way;
                    continue;
                }
                cross_.at(column, row) += regionCounts * way * way;
                around_.at(column, row) += regionCounts * way;
            }
        });
    }

    void setArms(std::uint32_t row) {
        for (std::uint32_t column = 0; column < columns_; ++column) {
            const auto& place = places_.at(column, row);
            if (!place.isSeen()) continue;
            const auto cross = cross_.at(column, row);
            const double angle = 0.25 * static_cast<double>(std::arg(cross));
            const TangentAxes axes(place.normal);
            const auto arm = [&](double x, double y) {
                const glm::dvec2 way = seenStep(camera_, place.at, x * axes.u + y * axes.v);
                const double length = glm::length(way);
                return length > 0.0 ? glm::vec2(way / length) : glm::vec2(1.0F, 0.0F);
            };
            auto& cell = field_.cells.at(column, row);
            cell.first = arm(std::cos(angle), std::sin(angle));
            cell.second = arm(-std::sin(angle), std::cos(angle));
        }
    }

    /// Which arm is the first one: where that is clear the one around the form, and from there on, the surest
    /// cells first, the one that goes on.
    void comb() {
        struct Front {
            float sure;
            std::uint32_t cell, from;
            bool operator<(const Front& other) const {
                return std::tie(sure, other.cell, other.from) < std::tie(other.sure, cell, from);
            }
        };
        std::vector<std::uint32_t> order;
        for (std::uint32_t i = 0; i < places_.values.size(); ++i) {
            if (places_.values[i].isSeen()) order.push_back(i);
        }
        const auto clear = [&](std::uint32_t i) { return std::abs(preferred(i)); };
        std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return clear(a) > clear(b); });
        std::vector<std::uint8_t> combed(places_.values.size());
        std::priority_queue<Front> fronts;
        auto& cells = field_.cells.values;
        const auto take = [&](std::uint32_t i, bool swapped) {
            combed[i] = 1;
            if (swapped) std::swap(cells[i].first, cells[i].second);
            const auto offer = [&](std::uint32_t other) {
                if (combed[other] == 0) fronts.push({std::abs(cross_.values[other]), other, i});
            };
            if (cells[i].right) offer(i + 1);
            if (cells[i].below) offer(i + columns_);
            if (i % columns_ > 0 && cells[i - 1].right) offer(i - 1);
            if (i >= columns_ && cells[i - columns_].below) offer(i - columns_);
        };
        const auto goOn = [&] {
            while (!fronts.empty()) {
                const auto front = fronts.top();
                fronts.pop();
                if (combed[front.cell] != 0) continue;
                const auto& cell = cells[front.cell];
                const auto& way = cells[front.from].first;
                take(front.cell, std::abs(glm::dot(cell.second, way)) > std::abs(glm::dot(cell.first, way)));
            }
        };
        bool alone =
            false;  // whether the way of cells is no longer clear, so that one speaks for those beside it
        for (const auto i : order) {
            if (isStopped(stop_)) return;
            if (!alone && clear(i) < aroundFrom) {
                goOn();
                alone = true;
            }
            if (combed[i] != 0) continue;
            take(i, preferred(i) < 0.0F);
            if (alone) goOn();
            giveWay();
        }
        goOn();
    }
    /// By how much the first of a cell's arms, before they are combed, goes around the form, and not the
    /// second.
    float preferred(std::uint32_t i) const {
        const float angle = 0.5F * std::arg(cross_.values[i]);
        return std::real(around_.values[i] * std::polar(1.0F, -angle));
    }

    const Modalities& modalities_;
    const InkCamera& camera_;
    const Segments& regions_;
    const FieldOptions& options_;
    const std::stop_token& stop_;
    const ContinuousSight sight_;
    const std::uint32_t columns_, rows_;
    Raster<Place> places_;    // of cells
    Raster<Complex> cross_;   // likewise; four times the angle in the tangent plane, as long as it is sure
    Raster<Complex> around_;  // likewise; twice the angle of the way in which it bends most
    HatchField field_;
};

}  // namespace

ContinuousSight::Place ContinuousSight::placeOf(std::uint32_t column, std::uint32_t row) const {
    const auto i = modalities_.depth.index(column, row);
    const auto depth = static_cast<double>(modalities_.depth.values[i]);
    Place place;
    if (!std::isfinite(depth)) return place;
    place.at = camera_.inEye({{column + 0.5, row + 0.5}, depth});
    place.normal = {0.0, 0.0, 1.0};
    if (!modalities_.across.values.empty()) {
        const auto across = static_cast<double>(modalities_.across.values[i]),
                   angle = static_cast<double>(modalities_.angle.values[i]);
        const double length = std::abs(across);
        place.normal = {length * std::cos(angle), -length * std::sin(angle),
                        std::copysign(std::sqrt(std::max(0.0, 1.0 - length * length)), across)};
        if (!std::isfinite(place.normal.x + place.normal.y)) place.normal = {0.0, 0.0, 1.0};
    }
    place.part = modalities_.part.values[i] == Modalities::nothing ? 0 : modalities_.part.values[i];
    return place;
}

bool ContinuousSight::goesOn(const Place& one, const Place& other) const {
    if (!one.isSeen() || one.part != other.part) return false;
    if (!(glm::dot(one.normal, other.normal) >= leastBend)) return false;
    const glm::dvec3 way = other.at - one.at;
    if (!(std::abs(way.z) <= mostDepthStep * modalities_.extent)) return false;
    const double rise = std::max(std::abs(glm::dot(way, one.normal)), std::abs(glm::dot(way, other.normal)));
    // What is no step at all may be as rough as it likes.
    return rise <= mostRise * glm::length(way) || rise <= alikeDepths * modalities_.extent;
}

bool ContinuousSight::alike(std::size_t one, std::size_t other) const {
    if (modalities_.part.values[one] != modalities_.part.values[other]) return false;
    if (!(std::abs(modalities_.depth.values[one] - modalities_.depth.values[other]) <=
          static_cast<float>(alikeDepths * modalities_.extent)))
        return false;
    return modalities_.across.values.empty() ||
           (std::abs(modalities_.across.values[one] - modalities_.across.values[other]) < alikeAcross &&
            std::abs(modalities_.angle.values[one] - modalities_.angle.values[other]) < alikeAngles);
}

bool ContinuousSight::operator()(std::uint32_t column, std::uint32_t row, std::uint32_t otherColumn,
                                 std::uint32_t otherRow) const {
    const auto one = modalities_.depth.index(column, row),
               other = modalities_.depth.index(otherColumn, otherRow);
    return one == other || alike(one, other) || goesOn(placeOf(column, row), placeOf(otherColumn, otherRow));
}

HatchField hatchField(const Modalities& modalities, const InkCamera& camera, const Segments& regions,
                      const std::vector<HatchStroke>& before, const FieldOptions& options,
                      const std::stop_token& stop) {
    return FieldMaker(modalities, camera, regions, options, stop).make(before);
}

}  // namespace mote::render
