// SPDX-License-Identifier: GPL-3.0-or-later
//
// HistogramPart: the part of a query that asks for histograms. Owned by a QueryRun; one thread.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/numbers/query_parts.h"
#include "storage/numbers/histogram.h"

namespace mote::server {

class HistogramPart final : public QueryPart {
  public:
    struct Axis {
        std::string column;  ///< or derived quantity
        std::uint32_t bins;
        std::optional<std::pair<double, double>> range;  ///< none: of all steps
    };
    /// Errors, at the field: invalidArgument.
    static Result<std::unique_ptr<HistogramPart>> make(const proto::HistogramQuery& query);
    HistogramPart(std::vector<Axis> axes, bool unweighted)
        : axes_(std::move(axes)), unweighted_(unweighted) {}

    Status answer(const StepQuestion& question, QueryAnswer& answer) override;
    const std::vector<Axis>& axes() const { return axes_; }
    /// The numbers alone, and what limits them. Errors as of answer().
    Result<storage::Histogram> count(const StepQuestion& question, proto::Answer& message);

  private:
    std::vector<Axis> axes_;  // ranges are those of all steps once they are known
    const bool unweighted_;
};

}  // namespace mote::server
