// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/ink/extinction_table.h"

#include <algorithm>
#include <limits>

namespace mote::render {

ExtinctionTable::ExtinctionTable(const GridField& field, const TransferTable& table) {
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
    const double cells = TransferTable::cells / (table.high() - table.low());
    scale_ = cells * (field.valueOf(1.0) - field.valueOf(0.0));
    offset_ = cells * (field.valueOf(0.0) - table.low());
}

}  // namespace mote::render
