// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/connection_parts.h"

#include "protocol/wire/framing.h"

namespace mote::client {

Error toError(const proto::Failure& failure) {
    Error error{ErrorCode::internal, failure.where(), failure.message()};
    for (int i = 0; i <= static_cast<int>(ErrorCode::internal); ++i) {
        const auto code = static_cast<ErrorCode>(i);
        if (name(code) == failure.code()) error.code = code;
    }
    if (error.message.empty()) error.message = "the server failed and gave no reason";
    return error;
}
Result<std::optional<WholeFrame>> FrameAssembly::add(proto::Frame message,
                                                     std::vector<std::uint8_t> payload) {
    if (message.payload_begin() == 0) {
        if (message.payload_size() > wire::serverLimits.payload)
            return corrupt("frame", "it is larger than any picture");
        open_ = {std::move(message), std::move(payload)};
        // One allocation, of what the sender has yet to send: it is no more than a whole frame might be.
        open_->payload.reserve(open_->message.payload_size());
    } else {
        if (!open_ || message.sequence() != open_->message.sequence() ||
            message.payload_begin() != open_->payload.size()) {
            open_.reset();
            return corrupt("frame", "a piece of it is missing");
        }
        open_->payload.insert(open_->payload.end(), payload.begin(), payload.end());
    }
    const std::uint64_t size = open_->message.payload_size();
    if (size != 0 && open_->payload.size() < size) return std::optional<WholeFrame>();
    auto whole = std::exchange(open_, std::nullopt);
    if (size != 0 && whole->payload.size() > size)
        return corrupt("frame", "its pieces are longer than it is");
    return whole;
}

}  // namespace mote::client
