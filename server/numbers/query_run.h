// SPDX-License-Identifier: GPL-3.0-or-later
//
// QueryRun: one query under way: its answers, one a step, in the order of the steps. Owned by the
// QueryService, used on one thread at a time; uses all threads of the calling arena.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/mote.pb.h"
#include "protocol/scene/selection.h"
#include "server/numbers/query_parts.h"

namespace mote::server {

class QueryRun {
  public:
    using Cancelled = std::function<bool()>;

    virtual ~QueryRun() = default;
    /// `context` outlives it. Errors, at the field: invalidArgument, notFound, unsupported.
    static Result<std::unique_ptr<QueryRun>> make(const proto::Query& query, QueryContext& context);

    /// The next answer, which says whether it is the last; not after an error. `cancelled` is asked on
    /// several threads. Errors: of the files, of the selection; resourceExhausted; cancelled.
    virtual Result<QueryAnswer> next(const Cancelled& cancelled) = 0;
};

/// Of a pick.
Result<std::unique_ptr<QueryRun>> makePickRun(const proto::PickQuery& query, QueryContext& context);

}  // namespace mote::server
