// SPDX-License-Identifier: GPL-3.0-or-later
//
// LatestQuery: a question for numbers of which only the latest form matters: another one takes its place,
// and the server hears that the one before is not wanted any more. Main thread.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "client/shared/connection.h"
#include "protocol/mote.pb.h"

namespace mote::client {

/// The way to a server: Connection::query and cancelQuery.
struct QueryLine {
    using Reply = Connection::Reply<QueryAnswer>;
    std::function<std::uint64_t(const proto::Query&, Reply)> ask;
    std::function<void(std::uint64_t)> cancel;
};

class LatestQuery {
  public:
    explicit LatestQuery(QueryLine line) : line_(std::move(line)) {}
    ~LatestQuery() { drop(); }
    LatestQuery(const LatestQuery&) = delete;
    LatestQuery& operator=(const LatestQuery&) = delete;

    /// Asks, unless this is what was asked last; true where it asks. `reply` hears each answer until the
    /// last, or an error; it must not outlive what it is given.
    bool want(const proto::Query& query, QueryLine::Reply reply);
    /// Nothing is wanted; the same question is then a new one.
    void drop();
    /// An answer is still to come.
    bool waits() const { return asking_ != 0; }

  private:
    void hear(const Result<QueryAnswer>& answer, const QueryLine::Reply& reply);

    QueryLine line_;
    std::string asked_;  // the message's bytes; empty: nothing
    std::optional<std::uint64_t> request_;
    std::uint64_t asking_ = 0;  // the number of the question under way; 0: none
    std::uint64_t questions_ = 0;
};

}  // namespace mote::client
