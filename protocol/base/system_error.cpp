// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/base/system_error.h"

#include <fmt/format.h>

#include <cerrno>
#include <system_error>

namespace mote {
namespace {

ErrorCode codeOf(int number) {
    switch (number) {
        case ENOENT:
        case ENOTDIR:
            return ErrorCode::notFound;
        case EACCES:
        case EPERM:
        case EROFS:
        case ELOOP:  // a link where none may be
            return ErrorCode::permissionDenied;
        case EEXIST:
        case ENOTEMPTY:
            return ErrorCode::alreadyExists;
        case ENOSPC:
        case EDQUOT:
        case EFBIG:
        case ENOMEM:
        case EAGAIN:  // of processes: too many
        case EMFILE:
        case ENFILE:
            return ErrorCode::resourceExhausted;
        default:
            return ErrorCode::internal;
    }
}

/// Not ENOMEM: what a limit refuses, it refuses again.
bool isPassing(int number) {
    switch (number) {
        case ENOSPC:
        case EDQUOT:
        case EFBIG:  // a job's limit is what is free
        case EMFILE:
        case ENFILE:
        case EAGAIN:
            return true;
        default:
            return false;
    }
}

}  // namespace

std::string systemMessage(int number) {
    return std::generic_category().message(number);
}

Error systemError(int number, std::string where, std::string_view what) {
    return {codeOf(number), std::move(where), fmt::format("{}: {}", what, systemMessage(number)),
            isPassing(number)};
}

Error failedCall(const char* call) {
    return {ErrorCode::internal, call, systemMessage(errno)};
}

}  // namespace mote
