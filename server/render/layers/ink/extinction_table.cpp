// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/extinction_table.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

namespace mote::render {

ExtinctionTable::ExtinctionTable(const GridField& field, const TransferTable& table)
    : low_(table.low()), cellsAUnit_(TransferTable::cells / (table.high() - table.low())) {
    double sum = 0.0;
    for (const auto& cell : table.ofCells()) {
        extinction_.push_back(cell.extinction);
        sums_.push_back(sum);
        sum += cell.extinction;
    }
    first_ = static_cast<double>(
        std::find_if(extinction_.begin(), extinction_.end(), [](double cell) { return cell > 0.0; }) -
        extinction_.begin());
    // Below its table a function goes on as it begins there.
    if (first_ == 0.0) first_ = -std::numeric_limits<double>::infinity();
    last_ = static_cast<double>(extinction_.size() - 1);
    scale_ = cellsAUnit_ * (field.valueOf(1.0) - field.valueOf(0.0));
    offset_ = cellsAUnit_ * (field.valueOf(0.0) - low_);
    most_ = {extinction_};
    for (std::size_t half = 1; 2 * half <= extinction_.size(); half *= 2) {
        const auto& halves = most_.back();
        std::vector<double> both(extinction_.size() - 2 * half + 1);
        for (std::size_t i = 0; i < both.size(); ++i) both[i] = std::max(halves[i], halves[i + half]);
        most_.push_back(std::move(both));
    }
}

double ExtinctionTable::most(double low, double high) const {
    const std::size_t first = cellOf(cellsAUnit_ * (low - low_)), last = cellOf(cellsAUnit_ * (high - low_));
    const std::size_t cells = std::max(first, last) - first + 1;
    const auto power = static_cast<std::size_t>(std::bit_width(cells | 1U) - 1);
    return std::max(most_[power][first], most_[power][first + cells - (std::size_t{1} << power)]);
}

}  // namespace mote::render
