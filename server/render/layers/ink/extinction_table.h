// SPDX-License-Identifier: GPL-3.0-or-later
//
// ExtinctionTable: what a ray loses between two samples of a field along which the value changes evenly: the
// mean of the extinction over values (pre-integration: Engel, Kraus and Ertl 2001, High-quality
// pre-integrated volume rendering). By codes of a grid field. A value, safe on any number of threads.
#pragma once

#include <algorithm>
#include <cmath>
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
    /// Whether no value between two places in the table has any extinction; most that rays go through has
    /// none.
    bool isNothing(double from, double to) const { return std::max(from, to) <= first_; }
    /// Extinction per unit length of layer space, the mean over the values between two places in the table.
    double mean(double from, double to) const {
        if (isNothing(from, to)) return 0.0;
        if (std::abs(to - from) < alike) return extinction_[cellOf(0.5 * (from + to))];
        return (integral(to) - integral(from)) / (to - from);
    }

    /// How extinction is spread between two places in the table.
    class Spread {
      public:
        Spread(const ExtinctionTable& table, double from, double to)
            : table_(table), from_(from), across_(to - from), even_(std::abs(across_) < alike) {
            if (even_) return;
            before_ = table.integral(from);
            perAll_ = 1.0 / (table.integral(to) - before_);
        }
        /// Which share of it, if there is some, lies before a share of the way.
        double operator()(double way) const {
            return even_ ? way : (table_.integral(from_ + way * across_) - before_) * perAll_;
        }

      private:
        const ExtinctionTable& table_;
        double from_, across_;
        bool even_;
        double before_ = 0.0, perAll_ = 0.0;
    };

    /// The greatest that any value in [low, high] has, in the field's unit.
    double most(double low, double high) const;

  private:
    // Cells by which two places differ at least if a difference of integrals tells their mean.
    static constexpr double alike = 1e-3;

    std::size_t cellOf(double at) const { return static_cast<std::size_t>(std::clamp(at, 0.0, last_)); }
    /// Over places in the table, up to one; beyond the table's ends the outermost cells go on.
    double integral(double at) const {
        const std::size_t cell = cellOf(at);
        return sums_[cell] + (at - static_cast<double>(cell)) * extinction_[cell];
    }

    std::vector<double> extinction_;  // of each cell
    std::vector<double> sums_;        // before each cell
    /// The greatest of 2^i cells from each on.
    std::vector<std::vector<double>> most_;
    double low_, cellsAUnit_;  // of the table
    double first_, last_;      // where extinction begins; the last cell
    double scale_, offset_;
};

}  // namespace mote::render
