// SPDX-License-Identifier: GPL-3.0-or-later
//
// QueryService: answers questions for numbers on threads of its own, at most half of the processor's and at a
// low priority, so that pictures keep their pace. A query is worked on answer by answer: when one was taken,
// proceed() has the next one made. So those who take nothing keep no thread, and many queries take turns.
// Owned by the server; any thread may ask.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/numbers/query_parts.h"

namespace mote::server {

class QueryService {
  public:
    /// Called on a thread of the service with each answer, or the error that ends the query; must be quick.
    using Answered = std::function<void(Result<QueryAnswer>)>;
    struct Query;  ///< one that was asked
    using Ticket = std::shared_ptr<Query>;

    /// `runs` outlives it. `memory`: bytes that queries may take besides the budget's blocks, and of the
    /// budget. `threads`: at least one.
    QueryService(RunSource& runs, std::shared_ptr<storage::BlockBudget> budget, std::uint64_t memory,
                 unsigned threads);
    /// Cancels what is under way and waits for it.
    ~QueryService();
    QueryService(const QueryService&) = delete;
    QueryService& operator=(const QueryService&) = delete;

    /// Has the first answer made.
    Ticket ask(proto::Query query, Answered answered);
    /// Has the next one made: once after each answer that was not the last.
    void proceed(const Ticket& ticket);
    /// Nothing more is made of it; what is under way stops, and an answer that was made just now may still
    /// come.
    void cancel(const Ticket& ticket);

    /// Queries on a thread or waiting for one.
    std::size_t underWay() const;

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

/// Threads for queries on a processor of so many.
unsigned queryThreads(unsigned processors);
/// What queries may take of what data may.
std::uint64_t queryMemory(std::uint64_t data);

}  // namespace mote::server
