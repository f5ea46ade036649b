// SPDX-License-Identifier: GPL-3.0-or-later
//
// SessionQueries: the queries of one client, of bounded number and size: those that wait, a few that are
// worked on, and answers that are to be sent. Owned by its session; one thread, that of the executor.
#pragma once

#include <asio/any_io_executor.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "server/numbers/query_service.h"
#include "server/session/message_account.h"

namespace mote::server {

class SessionQueries {
  public:
    static constexpr std::size_t mostAtWork = 4;  ///< whose answer is made, or not yet taken
    static constexpr std::size_t mostWaiting = 64;
    static constexpr std::size_t mostBytes = std::size_t{16} << 20;  ///< of all their messages, in memory

    struct Answered {
        std::uint64_t request = 0;
        Result<QueryAnswer> answer;
    };

    /// `service` may be null: then nothing is answered. `budget`: what messages are counted to, or null.
    SessionQueries(QueryService* service, asio::any_io_executor executor,
                   std::shared_ptr<storage::BlockBudget> budget);

    /// `ready` is called when take() may have something. Errors: resourceExhausted (there are too many),
    /// invalidArgument (a query with this number is not answered yet), unsupported.
    Status ask(std::uint64_t request, proto::Query query, std::function<void()> ready);
    /// The next answer that is to be sent; with that the query goes on.
    std::optional<Answered> take();
    /// It ends with a failure, which take() gives, where it is not answered yet.
    void cancel(std::uint64_t request);
    /// Stops all of them.
    void close();

  private:
    struct Waiting {
        std::uint64_t request;
        proto::Query query;
        std::function<void()> ready;
        MessageAccount::Hold hold;
    };
    struct AtWork {
        std::uint64_t serial;  ///< tells it from an earlier query of its number
        QueryService::Ticket ticket;
        MessageAccount::Hold hold;
    };
    /// What queries at work share with their session, on the executor's thread.
    struct Desk {
        std::map<std::uint64_t, AtWork> atWork;  ///< by request
        std::deque<Answered> answers;
    };
    void start();

    QueryService* const service_;
    const asio::any_io_executor executor_;
    MessageAccount account_;
    std::deque<Waiting> waiting_;
    std::uint64_t serial_ = 0;
    std::shared_ptr<Desk> desk_;  // null once closed
};

}  // namespace mote::server
