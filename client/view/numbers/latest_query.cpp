// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/numbers/latest_query.h"

#include <utility>

namespace mote::client {

bool LatestQuery::want(const proto::Query& query, QueryLine::Reply reply) {
    auto bytes = query.SerializeAsString();
    if (bytes == asked_) return false;
    drop();
    asked_ = std::move(bytes);
    const auto mine = ++questions_;
    asking_ = mine;
    const auto request = line_.ask(query, [this, mine, reply = std::move(reply)](Result<QueryAnswer> answer) {
        if (asking_ == mine) hear(answer, reply);
    });
    if (asking_ == mine) request_ = request;
    return true;
}

void LatestQuery::hear(const Result<QueryAnswer>& answer, const QueryLine::Reply& reply) {
    if (!answer.ok() || answer->message.last()) {
        asking_ = 0;
        request_.reset();
    }
    reply(answer);
}

void LatestQuery::drop() {
    asked_.clear();
    asking_ = 0;
    if (request_) line_.cancel(*std::exchange(request_, std::nullopt));
}

}  // namespace mote::client
