// SPDX-License-Identifier: GPL-3.0-or-later
//
// ExtinctionTable: what a ray loses between two samples of a field along which the value changes evenly: the
// mean of the extinction over values (pre-integration: Engel, Kraus and Ertl 2001, High-quality
// pre-integrated volume rendering). By codes of a grid field. A value, safe on any number of threads.
#pragma once

#include <cstddef>
#include <vector>

#include "protocol/scene/transfer_function.h"
#include "server/render/plan/grid_field.h"
#include "server/render/plan/transfer_table.h"

namespace mote::render {

class ExtinctionTable {
  public:
    /// `table`: of the field's transfer function.
    ExtinctionTable(const GridField& field, const TransferTable& table);

    /// Where a code lies in the table.
    double at(float code) const { return offset_ + scale_ * static_cast<double>(code); }
    /// Extinction per unit length of layer space, the mean over the values between two places in the table.
    double mean(double from, double to) const;

  private:
    std::size_t cellOf(double at) const;
    /// Over places in the table, up to one; beyond the table's ends the outermost cells go on.
    double integral(double at) const;

    std::vector<double> extinction_;  // of each cell
    std::vector<double> sums_;        // before each cell
    double scale_, offset_;
};

}  // namespace mote::render
