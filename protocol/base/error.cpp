// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/error.h"

#include <fmt/format.h>

#include <array>
#include <cstdio>

namespace mote {

void checkFailed(const char* condition, const char* file, int line) {
    const std::string broken = fmt::format("broken invariant {} at {}:{}", condition, file, line);
    fmt::print(stderr, "mote: {}\n", broken);
    throw BrokenInvariant(broken);
}

std::string_view name(ErrorCode code) {
    constexpr std::array<std::string_view, 9> names{"invalid_argument",   "not_found", "already_exists",
                                                    "permission_denied",  "corrupt",   "unsupported",
                                                    "resource_exhausted", "cancelled", "internal"};
    static_assert(names.size() == static_cast<std::size_t>(ErrorCode::internal) + 1);
    return names.at(static_cast<std::size_t>(code));
}

Error invalid(std::string_view where, std::string message) {
    return {ErrorCode::invalidArgument, std::string(where), std::move(message)};
}

Error notFound(std::string_view where, std::string message) {
    return {ErrorCode::notFound, std::string(where), std::move(message)};
}

Error corrupt(std::string_view where, std::string message) {
    return {ErrorCode::corrupt, std::string(where), std::move(message)};
}

Error unsupported(std::string_view where, std::string message) {
    return {ErrorCode::unsupported, std::string(where), std::move(message)};
}

Error wasCancelled(std::string message) {
    return {ErrorCode::cancelled, "", std::move(message)};
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
