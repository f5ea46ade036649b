// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/failure.h"

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

}  // namespace mote::client
