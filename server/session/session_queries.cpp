// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/session/session_queries.h"

#include <fmt/format.h>

#include <algorithm>
#include <asio/post.hpp>

namespace mote::server {

SessionQueries::SessionQueries(QueryService* service, asio::any_io_executor executor,
                               std::shared_ptr<storage::BlockBudget> budget)
    : service_(service),
      executor_(std::move(executor)),
      account_(mostBytes, std::move(budget)),
      desk_(std::make_shared<Desk>()) {}

Status SessionQueries::ask(std::uint64_t request, proto::Query query, std::function<void()> ready) {
    if (service_ == nullptr) return Error{ErrorCode::unsupported, "query", "this server answers no queries"};
    const auto bytes = query.SpaceUsedLong();
    // Refused, and not left unread: an answer may take longer than anybody waits for a sign of life.
    if (waiting_.size() >= mostWaiting || !account_.roomFor(bytes)) {
        return Error{
            ErrorCode::resourceExhausted, "query",
            fmt::format("at most {} queries of a client wait, and all take {} MiB in memory; ask again when "
                        "some are answered",
                        mostWaiting, mostBytes >> 20)};
    }
    const auto same = [&](const Waiting& one) { return one.request == request; };
    if ((desk_ && desk_->atWork.contains(request)) || std::ranges::any_of(waiting_, same))
        return Error{ErrorCode::invalidArgument, "request", "a query with this number is not answered yet"};
    waiting_.push_back({request, std::move(query), std::move(ready), account_.hold(bytes)});
    start();
    return success();
}

void SessionQueries::start() {
    while (desk_ && desk_->atWork.size() < mostAtWork && !waiting_.empty()) {
        auto next = std::move(waiting_.front());
        waiting_.pop_front();
        auto answered = [executor = executor_, desk = std::weak_ptr(desk_), request = next.request,
                         serial = ++serial_, ready = std::move(next.ready)](Result<QueryAnswer> answer) {
            asio::post(executor, [desk, request, serial, ready, answer = std::move(answer)]() mutable {
                const auto own = desk.lock();
                if (!own) return;
                const auto found = own->atWork.find(request);
                if (found == own->atWork.end() || found->second.serial != serial) return;  // it was cancelled
                own->answers.push_back({request, std::move(answer)});
                ready();
            });
        };
        desk_->atWork[next.request] = {serial_, service_->ask(std::move(next.query), std::move(answered)),
                                       std::move(next.hold)};
    }
}

std::optional<SessionQueries::Answered> SessionQueries::take() {
    if (!desk_ || desk_->answers.empty()) return std::nullopt;
    auto answered = std::move(desk_->answers.front());
    desk_->answers.pop_front();
    const auto found = desk_->atWork.find(answered.request);
    if (found == desk_->atWork.end()) return answered;  // it was cancelled: this says so
    if (answered.answer.ok() && !answered.answer->message.last()) {
        service_->proceed(found->second.ticket);
    } else {
        desk_->atWork.erase(found);
        start();
    }
    return answered;
}

void SessionQueries::cancel(std::uint64_t request) {
    if (!desk_) return;
    const auto waits = std::ranges::find(waiting_, request, &Waiting::request);
    const auto works = desk_->atWork.find(request);
    if (waits != waiting_.end()) {
        waiting_.erase(waits);
    } else if (works != desk_->atWork.end()) {
        service_->cancel(works->second.ticket);
        desk_->atWork.erase(works);
        std::erase_if(desk_->answers, [&](const Answered& one) { return one.request == request; });
    } else {
        return;
    }
    desk_->answers.push_back({request, Error{ErrorCode::cancelled, "query", "cancelled on request"}});
    start();
}

void SessionQueries::close() {
    if (!desk_) return;
    for (const auto& [request, one] : desk_->atWork) service_->cancel(one.ticket);
    waiting_.clear();
    desk_ = nullptr;
}

}  // namespace mote::server
