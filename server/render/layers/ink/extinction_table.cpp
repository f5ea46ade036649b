// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/extinction_table.h"

#include <algorithm>
#include <cmath>

namespace mote::render {
namespace {

// Cells by which two places differ at least where a difference of integrals tells their mean.
constexpr double alike = 1e-3;

}  // namespace

ExtinctionTable::ExtinctionTable(const GridField& field, const TransferTable& table) {
    double sum = 0.0;
    for (const auto& cell : table.ofCells()) {
        extinction_.push_back(cell.extinction);
        sums_.push_back(sum);
        sum += cell.extinction;
    }
    const double cells = TransferTable::cells / (table.high() - table.low());
    scale_ = cells * (field.valueOf(1.0) - field.valueOf(0.0));
    offset_ = cells * (field.valueOf(0.0) - table.low());
}

std::size_t ExtinctionTable::cellOf(double at) const {
    return static_cast<std::size_t>(
        std::clamp(std::floor(at), 0.0, static_cast<double>(extinction_.size() - 1)));
}

double ExtinctionTable::integral(double at) const {
    const std::size_t cell = cellOf(at);
    return sums_[cell] + (at - static_cast<double>(cell)) * extinction_[cell];
}

double ExtinctionTable::mean(double from, double to) const {
    if (std::abs(to - from) < alike) return extinction_[cellOf(0.5 * (from + to))];
    return (integral(to) - integral(from)) / (to - from);
}

}  // namespace mote::render
