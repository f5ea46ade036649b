// SPDX-License-Identifier: GPL-3.0-or-later
//
// The viewer's programs do not name libavcodec: they load it where it is.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>

#include "client/shared/decode.h"

namespace mote::client {
namespace {

/// Run twice: with the library, and with a file in its place that is none (CMakeLists.txt).
TEST(WithoutLibavcodec, H264IsNeitherOfferedNorDecoded) {
    const bool hidden = std::getenv("MOTE_TEST_HIDES_LIBAVCODEC") != nullptr;
    EXPECT_EQ(H264Decoder::available(), !hidden);
    H264Decoder decoder;
    const std::array<std::uint8_t, 4> payload{0, 0, 1, 9};
    const auto error = decoder.decode(16, 16, true, payload).error();
    EXPECT_EQ(error.code, hidden ? ErrorCode::unsupported : ErrorCode::corrupt);
    EXPECT_EQ(error.message == "libavcodec is not on this machine", hidden) << error.message;
}

}  // namespace
}  // namespace mote::client
