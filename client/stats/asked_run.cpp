// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/stats/asked_run.h"

#include <fmt/format.h>

#include <deque>
#include <memory>
#include <utility>

#include "protocol/scene/json.h"
#include "protocol/scene/selection.h"
#include "protocol/scene/step_range.h"

namespace mote::client {
namespace {

Result<proto::Selection> readSelection(const std::filesystem::path& file) {
    proto::Selection selection;
    MOTE_RETURN_IF_ERROR(readJsonFile(file, selection));
    const auto parsed = parseSelection(selection);
    if (parsed.ok()) return selection;
    const auto& error = parsed.error();
    return Error{error.code,
                 error.where.empty() ? file.string() : fmt::format("{}: {}", file.string(), error.where),
                 error.message};
}

}  // namespace

Result<AskedRun> AskedRun::open(const StatsOptions& options, ServerLine& server) {
    AskedRun run(server, options.dataset);
    if (!options.select.empty()) {
        MOTE_ASSIGN_OR_RETURN(run.selection_, readSelection(options.select));
    }
    MOTE_RETURN_IF_ERROR(server.waitUntilConnected());
    MOTE_ASSIGN_OR_RETURN(auto description, server.answerTo<proto::Description>([&](auto reply) {
        server.line().describe(options.dataset, std::move(reply));
    }));
    auto& manifest = *description.mutable_manifest();
    if (manifest.kind() != "particles") {
        return Error{ErrorCode::unsupported, options.dataset,
                     fmt::format("holds no particles: it is of kind \"{}\"", manifest.kind())};
    }
    run.manifest_ = std::move(*manifest.mutable_particles());
    auto steps = selectSteps(options.steps, static_cast<std::size_t>(run.manifest_.steps_size()));
    if (!steps.ok()) return Error{steps.error().code, "--steps", steps.error().message};
    run.steps_ = *std::move(steps);
    return run;
}

std::string AskedRun::stepsText() const {
    const auto stride = steps_.size() > 1 ? steps_[1] - steps_[0] : 1;
    return fmt::format("{}:{}:{}", steps_.front(), steps_.back(), stride);
}

proto::Query AskedRun::query() const {
    proto::Query query;
    query.set_dataset(dataset_);
    query.set_steps(stepsText());
    if (selection_) *query.mutable_select() = *selection_;
    return query;
}

Status AskedRun::ask(const proto::Query& query, const std::vector<std::size_t>& steps,
                     const std::function<Status(const QueryAnswer&)>& take) {
    // Shared with the line, which may hold a reply longer than this function runs.
    const auto answers = std::make_shared<std::deque<Result<QueryAnswer>>>();
    const auto request = server_->line().query(
        query, [answers](Result<QueryAnswer> answer) { answers->push_back(std::move(answer)); });
    const auto told = [&]() -> Status {
        for (std::size_t i = 0; i < steps.size(); ++i) {
            MOTE_RETURN_IF_ERROR(server_->waitUntil([&] { return !answers->empty(); }));
            const auto answer = std::move(answers->front());
            answers->pop_front();
            if (!answer.ok()) return answer.error();
            if (answer->message.step() != steps[i] || answer->message.last() != (i + 1 == steps.size()))
                return Error{ErrorCode::corrupt, "",
                             "the server answered for other steps than it was asked for"};
            MOTE_RETURN_IF_ERROR(take(*answer));
        }
        return success();
    }();
    if (told.ok()) return told;
    server_->line().cancelQuery(request);
    server_->farewell();
    return told;
}

}  // namespace mote::client
