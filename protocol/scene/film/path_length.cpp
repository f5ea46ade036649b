// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/film/path_length.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

namespace mote {
namespace {

constexpr std::size_t mostCells = 1 << 16, leastPerWay = 16, mostPerWay = 256;

}  // namespace

PathLength::PathLength(const CameraPath& path)
    : path_(path), cells_(std::clamp(mostCells / path.ways(), leastPerWay, mostPerWay)), lengths_{0.0} {
    const auto count = static_cast<double>(cells_);
    for (std::size_t way = 0; way < path.ways(); ++way) {
        for (std::size_t i = 0; i < cells_; ++i) {
            const auto cell = static_cast<double>(i);
            lengths_.push_back(lengths_.back() + between(way, cell / count, (cell + 1.0) / count));
        }
    }
}

double PathLength::ofWay(std::size_t way) const {
    return lengths_[(way + 1) * cells_] - lengths_[way * cells_];
}

/// By a difference that is small against a cell, and large against the rounding of places.
double PathLength::speed(std::size_t way, double share) const {
    constexpr double reach = 1e-4;
    const double from = std::max(0.0, share - reach), to = std::min(1.0, share + reach);
    const auto a = path_.at(way, from), b = path_.at(way, to);
    return std::max(glm::distance(a.eye, b.eye), glm::distance(a.target, b.target)) / (to - from);
}

/// Gauss and Legendre's rule with four points.
double PathLength::between(std::size_t way, double from, double to) const {
    constexpr std::array<std::pair<double, double>, 4> rule{{{-0.8611363115940526, 0.3478548451374538},
                                                             {-0.3399810435848563, 0.6521451548625461},
                                                             {0.3399810435848563, 0.6521451548625461},
                                                             {0.8611363115940526, 0.3478548451374538}}};
    double sum = 0.0;
    for (const auto& [place, weight] : rule)
        sum += weight * speed(way, 0.5 * (from + to) + 0.5 * place * (to - from));
    return 0.5 * (to - from) * sum;
}

/// The share of the way in a cell where it is `length` beyond the cell's beginning: Newton's method, held in
/// what is known to hold the place.
double PathLength::shareAfter(std::size_t way, double from, double to, double length) const {
    const double whole = between(way, from, to);
    if (!(length < whole)) return to;
    double low = from, high = to, share = from + (to - from) * length / whole;
    for (int i = 0; i < 60 && high - low > 1e-14; ++i) {
        const double beyond = between(way, from, share) - length;
        (beyond > 0.0 ? high : low) = share;
        const double step = beyond / speed(way, share);
        if (std::abs(step) < 1e-14) break;
        const double next = share - step;
        share = next > low && next < high ? next : 0.5 * (low + high);
    }
    return share;
}

PathLength::Place PathLength::at(double length) const {
    const auto above = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, length);
    const auto cell = static_cast<std::size_t>(above - lengths_.begin()) - 1;
    const auto count = static_cast<double>(cells_);
    const auto inWay = static_cast<double>(cell % cells_);
    const auto way = cell / cells_;
    return {way,
            shareAfter(way, inWay / count, (inWay + 1.0) / count, std::max(0.0, length - lengths_[cell]))};
}

}  // namespace mote
