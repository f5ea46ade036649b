// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/agreement.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "server/render/ranks/byte_stream.h"
#include "storage/caught_error.h"

namespace mote::render {
namespace {

Bytes packError(const std::optional<Error>& error) {
    ByteWriter out;
    if (error) {
        out.put(error->code);
        out.putList(error->where);
        out.putList(error->message);
    }
    return out.take();
}

}  // namespace

void Agreement::keepHandled() noexcept {
    error_ =
        storage::caughtError({ErrorCode::resourceExhausted, "view", "there is not enough memory to draw it"});
}

bool Agreement::all(const std::stop_token& stop) {
    constexpr std::uint64_t well = 0, stopped = 1, failed = 2;
    const std::uint64_t worst = ranks_.greatest(error_ ? failed : stop.stop_requested() ? stopped : well);
    wentOn_ = worst == well;
    if (worst == failed) {
        const auto errors = exchangeErrors();
        if (ranks_.rank() == 0) takeFirst(errors);
    }
    return wentOn_;
}

bool Agreement::paused(const std::stop_token& pause) {
    return ranks_.greatest(pause.stop_requested() ? 1 : 0) != 0;
}

/// Everyone's, on rank 0.
std::vector<Bytes> Agreement::exchangeErrors() const noexcept {
    std::vector<Bytes> outgoing(static_cast<std::size_t>(ranks_.size()));
    outgoing[0] = packError(error_);
    return ranks_.exchange(outgoing);
}

void Agreement::takeFirst(const std::vector<Bytes>& errors) {
    for (std::size_t rank = 0; rank < errors.size(); ++rank) {
        if (errors[rank].empty()) continue;
        ByteReader in(errors[rank]);
        const auto code = in.get<ErrorCode>();
        auto where = in.getList<std::string>();
        error_ = Error{code, std::move(where), in.getList<std::string>()};
        if (rank != 0) error_->message = fmt::format("rank {}: {}", rank, error_->message);
        return;
    }
}

}  // namespace mote::render
