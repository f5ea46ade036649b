// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/numbers/query_run.h"

#include "protocol/scene/step_range.h"
#include "storage/storage_error.h"

namespace mote::server {
namespace {

class StepsRun final : public QueryRun {
  public:
    StepsRun(QueryContext& context, SelectionResults::Run run, std::vector<std::size_t> steps,
             Selection selection, std::unique_ptr<QueryPart> part)
        : context_(context),
          run_(std::move(run)),
          steps_(std::move(steps)),
          selection_(std::move(selection)),
          part_(std::move(part)) {}

    Result<QueryAnswer> next(const Cancelled& cancelled) override {
        for (;;) {
            const auto step = static_cast<std::uint32_t>(steps_.at(done_++));
            const bool last = done_ == steps_.size();
            QueryAnswer answer;
            const StepQuestion question(context_, run_, step, selection_, cancelled);
            answer.message.set_step(step);
            answer.message.set_last(last);
            answer.message.set_iteration(question.entry().iteration());
            answer.message.set_time(question.entry().time());
            try {
                MOTE_RETURN_IF_ERROR(part_->answer(question, answer));
            } catch (const storage::StorageError& error) {
                return error.error();
            }
            if (last || !part_->ofAllSteps()) return answer;
        }
    }

  private:
    QueryContext& context_;
    const SelectionResults::Run run_;
    const std::vector<std::size_t> steps_;
    std::size_t done_ = 0;
    const Selection selection_;
    const std::unique_ptr<QueryPart> part_;
};

/// An error of a part within its field.
MadePart within(MadePart part, std::string_view field) {
    MOTE_RETURN_IF_ERROR(part, field);
    return part;
}

MadePart partOf(const proto::Query& query) {
    switch (query.what_case()) {
        case proto::Query::kStatistics:
            return within(statisticsPart(query.statistics()), "statistics");
        case proto::Query::kHistogram:
            return within(histogramPart(query.histogram()), "histogram");
        case proto::Query::kColumns:
            return within(columnsPart(query.columns()), "columns");
        case proto::Query::kFigure:
            return within(figurePart(query.figure()), "figure");
        default:
            return Error{ErrorCode::unsupported, "", "what is asked is not known here"};
    }
}

Result<std::unique_ptr<QueryRun>> makeRun(const proto::Query& query, QueryContext& context) {
    if (query.has_pick()) {
        auto pick = makePickRun(query.pick(), context);
        MOTE_RETURN_IF_ERROR(pick, "pick");
        return pick;
    }
    MOTE_ASSIGN_OR_RETURN(auto part, partOf(query));
    auto selection = parseSelection(query.select());
    MOTE_RETURN_IF_ERROR(selection, "select");
    MOTE_ASSIGN_OR_RETURN(auto run, context.runs.run(query.dataset()));
    MOTE_ASSIGN_OR_RETURN(auto steps,
                          selectSteps(query.steps(), static_cast<std::size_t>(run->manifest().steps_size())));
    return Result<std::unique_ptr<QueryRun>>(std::make_unique<StepsRun>(
        context, std::move(run), std::move(steps), *std::move(selection), std::move(part)));
}

}  // namespace

Result<std::unique_ptr<QueryRun>> QueryRun::make(const proto::Query& query, QueryContext& context) {
    auto run = makeRun(query, context);
    MOTE_RETURN_IF_ERROR(run, "query");
    return run;
}

}  // namespace mote::server
