// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/video/libav.h"

#include <fmt/format.h>

#include "protocol/scene/system_error.h"

namespace mote::client {

Error libavError(int code, const std::string& where) {
    constexpr int mostErrno = 4095;  // libav's own codes are four letters, far beyond
    const int number = AVUNERROR(code);
    if (number > 0 && number <= mostErrno) return systemError(number, where, "cannot be written");
    char text[AV_ERROR_MAX_STRING_SIZE] = {};
    av_strerror(code, text, sizeof text);
    return {ErrorCode::internal, where, fmt::format("the film cannot be encoded: {}", text)};
}

}  // namespace mote::client
