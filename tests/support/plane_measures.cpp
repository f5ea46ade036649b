// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/plane_measures.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

namespace mote::test {
namespace {

double cross(glm::dvec2 a, glm::dvec2 b) {
    return a.x * b.y - a.y * b.x;
}

/// Points in boxes of about one point each.
class Boxes {
  public:
    explicit Boxes(const std::vector<glm::dvec2>& points)
        : side_(std::max(1, static_cast<int>(std::sqrt(static_cast<double>(points.size()))))),
          boxes_(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_)) {
        for (const auto& point : points) {
            const auto wrapped = point - glm::dvec2(std::floor(point.x), std::floor(point.y));
            boxes_[indexOf(boxOf(wrapped.x), boxOf(wrapped.y))].push_back(wrapped);
        }
    }

    /// Calls with the difference from `at` to each point of the ring of boxes that lies `ring` away.
    template <class Visit>
    void ring(glm::dvec2 at, int ring, const Visit& visit) const {
        const int column = static_cast<int>(std::floor(at.x * side_));
        const int row = static_cast<int>(std::floor(at.y * side_));
        for (int y = row - ring; y <= row + ring; ++y) {
            const bool whole = std::abs(y - row) == ring;
            for (int x = column - ring; x <= column + ring; x += whole || ring == 0 ? 1 : 2 * ring) {
                const glm::dvec2 periods(floorDivide(x), floorDivide(y));
                for (const auto& point : boxes_[indexOf(x - static_cast<int>(periods.x) * side_,
                                                        y - static_cast<int>(periods.y) * side_)]) {
                    visit(point + periods - at);
                }
            }
        }
    }
    double boxSize() const { return 1.0 / side_; }

  private:
    int boxOf(double coordinate) const { return std::min(side_ - 1, static_cast<int>(coordinate * side_)); }
    int floorDivide(int box) const { return static_cast<int>(std::floor(static_cast<double>(box) / side_)); }
    std::size_t indexOf(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) +
               static_cast<std::size_t>(column);
    }

    int side_;
    std::vector<std::vector<glm::dvec2>> boxes_;
};

using Polygon = std::vector<glm::dvec2>;

/// Keeps what is nearer to 0 than to `other`.
void clip(Polygon& polygon, glm::dvec2 other, Polygon& kept) {
    kept.clear();
    const double limit = 0.5 * glm::dot(other, other);
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const auto a = polygon[i];
        const auto b = polygon[(i + 1) % polygon.size()];
        const double da = limit - glm::dot(a, other);
        const double db = limit - glm::dot(b, other);
        if (da >= 0.0) kept.push_back(a);
        if ((da < 0.0) != (db < 0.0)) kept.push_back(a + da / (da - db) * (b - a));
    }
    polygon.swap(kept);
}

double radiusOf(const Polygon& polygon) {
    double radius2 = 0.0;
    for (const auto& corner : polygon) radius2 = std::max(radius2, glm::dot(corner, corner));
    return std::sqrt(radius2);
}

VoronoiCell cellAt(const Boxes& boxes, glm::dvec2 at) {
    // No point is further from another than half of the period's diagonal.
    Polygon polygon{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    Polygon kept;
    VoronoiCell cell;
    cell.nearest = std::numeric_limits<double>::infinity();
    // A point further away than twice the radius cuts nothing off.
    for (int ring = 0; (ring - 1) * boxes.boxSize() <= 2.0 * radiusOf(polygon); ++ring) {
        boxes.ring(at, ring, [&](glm::dvec2 other) {
            const double distance = glm::length(other);
            if (distance == 0.0) return;
            cell.nearest = std::min(cell.nearest, distance);
            clip(polygon, other, kept);
        });
    }
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const auto a = polygon[i];
        const auto b = polygon[(i + 1) % polygon.size()];
        const double area = 0.5 * cross(a, b);
        cell.area += area;
        cell.centroid += area / 3.0 * (a + b);
        cell.secondMoment += area / 6.0 * (glm::dot(a, a) + glm::dot(b, b) + glm::dot(a, b));
    }
    cell.centroid /= cell.area;
    return cell;
}

/// exp(-2 pi i k x) for k = 0 to reach.
void powers(double x, std::vector<std::complex<double>>& out) {
    const auto step = std::polar(1.0, -2.0 * std::numbers::pi * x);
    std::complex<double> power = 1.0;
    for (auto& value : out) {
        value = power;
        power = {power.real() * step.real() - power.imag() * step.imag(),
                 power.real() * step.imag() + power.imag() * step.real()};
    }
}

}  // namespace

std::vector<VoronoiCell> voronoiCells(const std::vector<glm::dvec2>& points) {
    const Boxes boxes(points);
    std::vector<VoronoiCell> cells;
    for (const auto& point : points) {
        cells.push_back(cellAt(boxes, point - glm::dvec2(std::floor(point.x), std::floor(point.y))));
    }
    return cells;
}

std::vector<double> spectrum(const std::vector<glm::dvec2>& points, int reach) {
    const auto half = static_cast<std::size_t>(reach) + 1;
    const std::size_t side = 2 * half - 1;
    std::vector<double> real(half * side);  // f.y >= 0: the rest mirrors it
    std::vector<double> imaginary(half * side);
    std::vector<std::complex<double>> x(half);
    std::vector<std::complex<double>> y(half);
    std::vector<double> rowReal(side);
    std::vector<double> rowImaginary(side);
    for (const auto& point : points) {
        powers(point.x, x);
        powers(point.y, y);
        for (std::size_t k = 0; k < half; ++k) {
            rowReal[half - 1 + k] = rowReal[half - 1 - k] = x[k].real();
            rowImaginary[half - 1 + k] = x[k].imag();
            rowImaginary[half - 1 - k] = -x[k].imag();
        }
        for (std::size_t row = 0; row < half; ++row) {
            const double c = y[row].real();
            const double s = y[row].imag();
            double* re = &real[row * side];
            double* im = &imaginary[row * side];
            for (std::size_t k = 0; k < side; ++k) {
                re[k] += c * rowReal[k] - s * rowImaginary[k];
                im[k] += c * rowImaginary[k] + s * rowReal[k];
            }
        }
    }
    std::vector<double> power(side * side);
    for (std::size_t i = 0; i < half * side; ++i) {
        const double value =
            (real[i] * real[i] + imaginary[i] * imaginary[i]) / static_cast<double>(points.size());
        power[(half - 1) * side + i] = value;
        power[half * side - 1 - i] = value;
    }
    return power;
}

PlaneMeasures measurePlane(const std::vector<glm::dvec2>& points) {
    const auto n = static_cast<double>(points.size());
    const double hexagonal = std::sqrt(2.0 / (std::sqrt(3.0) * n));  // distance
    PlaneMeasures measures;
    double least = std::numeric_limits<double>::infinity();
    double square = 0.0;
    for (const auto& cell : voronoiCells(points)) {
        least = std::min(least, cell.nearest);
        measures.nearest += cell.nearest / n / hexagonal;
        measures.energy += n * cell.secondMoment / (5.0 / (18.0 * std::sqrt(3.0)));
        square += cell.area * cell.area * n;
    }
    measures.rho = least / hexagonal;
    measures.areaCv = std::sqrt(std::max(0.0, square - 1.0));
    const double limit = 0.5 * std::sqrt(n);
    const int reach = static_cast<int>(limit);
    const auto power = spectrum(points, reach);
    int count = 0;
    for (int y = -reach, i = 0; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x, ++i) {
            const double f = std::hypot(x, y);
            if (f == 0.0 || f >= limit) continue;
            measures.lowEnergy += power[static_cast<std::size_t>(i)];
            ++count;
        }
    }
    measures.lowEnergy /= std::max(1, count);
    return measures;
}

}  // namespace mote::test
