// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/scene/error.h"

#include <fmt/format.h>

#include <cstdio>

namespace mote {

void checkFailed(const char* condition, const char* file, int line) {
    const std::string broken = fmt::format("broken invariant {} at {}:{}", condition, file, line);
    fmt::print(stderr, "mote: {}\n", broken);
    throw BrokenInvariant(broken);
}

std::string_view name(ErrorCode code) {
    switch (code) {
        case ErrorCode::invalidArgument:
            return "invalid_argument";
        case ErrorCode::notFound:
            return "not_found";
        case ErrorCode::alreadyExists:
            return "already_exists";
        case ErrorCode::permissionDenied:
            return "permission_denied";
        case ErrorCode::corrupt:
            return "corrupt";
        case ErrorCode::unsupported:
            return "unsupported";
        case ErrorCode::resourceExhausted:
            return "resource_exhausted";
        case ErrorCode::cancelled:
            return "cancelled";
        case ErrorCode::internal:
            return "internal";
    }
    return "internal";
}

std::string Error::toString() const {
    return where.empty() ? message : fmt::format("{}: {}", where, message);
}

Error Error::within(std::string_view outer) const {
    Error nested = *this;
    const bool needsDot = !where.empty() && where.front() != '[' && !outer.empty();
    nested.where = fmt::format("{}{}{}", outer, needsDot ? "." : "", where);
    return nested;
}

}  // namespace mote
