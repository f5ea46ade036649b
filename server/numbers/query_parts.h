// SPDX-License-Identifier: GPL-3.0-or-later
//
// The parts of queries: what each kind of question answers of a step. Owned by a QueryRun, used on one thread
// at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/data/step_source.h"
#include "server/numbers/query_memory.h"
#include "server/numbers/selection_results.h"
#include "storage/numbers/histogram.h"
#include "storage/numbers/quantity_range.h"

namespace mote::server {

/// What all queries share.
struct QueryContext {
    RunSource& runs;
    std::shared_ptr<QueryMemory> memory;
    SelectionResults& selections;
};

/// Answer: a message and the bytes that go with it, whose memory is counted as long as it is here.
struct QueryAnswer {
    proto::Answer message;
    std::vector<std::uint8_t> payload;
    QueryMemory::Hold memory;
};

/// A step that something is asked of.
class StepQuestion {
  public:
    using Cancelled = std::function<bool()>;

    StepQuestion(QueryContext& context, SelectionResults::Run run, std::uint32_t step,
                 const Selection& selection, const Cancelled& cancelled)
        : context_(context),
          run_(std::move(run)),
          step_(step),
          selection_(selection),
          cancelled_(cancelled) {}

    const proto::ParticlesManifest& manifest() const { return run_->manifest(); }
    const proto::ParticleStepEntry& entry() const { return manifest().steps(static_cast<int>(step_)); }
    const storage::RunSteps& run() const { return *run_; }
    const Cancelled& cancelled() const { return cancelled_; }
    bool everything() const { return selection_.everything(); }

    /// With columns. Errors: notFound, corrupt.
    Result<storage::StepNumbers> numbers() const;
    /// With columns, if there are any. Errors: corrupt.
    Result<storage::StepNumbers> points() const { return run_->step(step_); }
    /// Null: all points. Errors: as SelectionResults.
    Result<SelectionResults::Mask> chosen() const;
    Result<SelectionResults::Ids> ids() const;
    Result<QueryMemory::Hold> take(std::uint64_t bytes) const {
        return context_.memory->take(bytes, cancelled_);
    }

  private:
    QueryContext& context_;
    const SelectionResults::Run run_;
    const std::uint32_t step_;
    const Selection& selection_;
    const Cancelled& cancelled_;
};

class QueryPart {
  public:
    virtual ~QueryPart() = default;
    /// Fills in what is told of the step; the step itself is said already. Errors: of the files, of a
    /// selection; resourceExhausted; cancelled. May throw storage::StorageError.
    virtual Status answer(const StepQuestion& question, QueryAnswer& answer) = 0;
    /// Whether the answer of `last` alone is sent, which is of all steps then.
    virtual bool ofAllSteps() const { return false; }
};

using MadePart = Result<std::unique_ptr<QueryPart>>;

/// Names of columns or statistics. Errors: invalidArgument, at "names" or one of them.
Status checkNames(const google::protobuf::RepeatedPtrField<std::string>& names);

/// Errors: invalidArgument, at the field.
MadePart statisticsPart(const proto::StatisticsQuery& query);
MadePart histogramPart(const proto::HistogramQuery& query);
MadePart columnsPart(const proto::ColumnsQuery& query);
MadePart figurePart(const proto::FigureQuery& query);

/// The part of a query that asks for histograms.
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
    /// Nothing: it asks for quantities.
    std::optional<Result<storage::Histogram>> countLeaves(const StepQuestion& question) const;

    std::vector<Axis> axes_;  // ranges are those of all steps once they are known
    const bool unweighted_;
};

}  // namespace mote::server
