// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/encoding_choice.h"

namespace mote::server {
namespace {

// Shares of the budget: the first lossless picture must fit with room to spare, the next ones must just fit.
constexpr double toBegin = 0.8;
constexpr double toStay = 1.1;

}  // namespace

proto::Frame::Encoding chooseEncoding(const EncodingTarget& target, const PictureFacts& picture) {
    if (picture.exact) return proto::Frame::ZSTD;
    if (target.measured && target.frameBytes) {
        const double most =
            (picture.wasLossless ? toStay : toBegin) * static_cast<double>(*target.frameBytes);
        if (static_cast<double>(picture.losslessBytes) <= most) return proto::Frame::ZSTD;
    }
    return target.h264 ? proto::Frame::H264 : proto::Frame::JPEG;
}

}  // namespace mote::server
