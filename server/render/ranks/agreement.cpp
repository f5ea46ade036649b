// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/ranks/agreement.h"

#include <fmt/format.h>

#include "server/render/ranks/byte_stream.h"

namespace mote::render {

bool Agreement::all(const std::stop_token& stop) {
    constexpr std::uint64_t well = 0, stopped = 1, failed = 2;
    const std::uint64_t worst = ranks_.greatest(error_ ? failed : stop.stop_requested() ? stopped : well);
    if (worst == failed) collectErrors();
    return worst == well;
}

void Agreement::collectErrors() {
    ByteWriter mine;
    if (error_) {
        mine.put(error_->code);
        mine.putList(error_->where);
        mine.putList(error_->message);
    }
    std::vector<Bytes> outgoing(static_cast<std::size_t>(ranks_.size()));
    outgoing[0] = mine.take();
    const auto all = ranks_.exchange(outgoing);
    if (ranks_.rank() != 0) return;
    for (std::size_t rank = 0; rank < all.size(); ++rank) {
        if (all[rank].empty()) continue;
        ByteReader in(all[rank]);
        const auto code = in.get<ErrorCode>();
        auto where = in.getList<std::string>();
        error_ = Error{code, std::move(where), in.getList<std::string>()};
        if (rank != 0) error_->message = fmt::format("rank {}: {}", rank, error_->message);
        return;
    }
}

}  // namespace mote::render
