// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/frame_encoder.h"

#include "protocol/wire/row_filter.h"
#include "server/encode/encode.h"

namespace mote::server {
namespace {

/// What no lossless picture exceeds by much: a link that carries this needs no closer look.
std::size_t rawBytes(const render::Picture& picture) {
    return std::size_t{picture.width} * picture.height * wire::filteredPixelSize(wireFormat(picture.format));
}

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

Result<EncodedPicture> FrameEncoder::encode(const render::Picture& picture, bool exact,
                                            const EncodingTarget& target) {
    PictureFacts facts{exact, 0, wasLossless_};
    if (!exact && target.frameBytes && *target.frameBytes < 2 * rawBytes(picture)) {
        MOTE_ASSIGN_OR_RETURN(facts.losslessBytes, lossless_.expectedBytes(picture));
    }
    auto encoding = chooseEncoding(target, facts);
    if (!exact) wasLossless_ = encoding == proto::Frame::ZSTD;
    if (encoding == proto::Frame::H264 && h264Works_) {
        auto made = encodeH264(picture, target);
        if (made.ok() || made.error().code != ErrorCode::unsupported) return made;
        h264Works_ = false;
    }
    if (encoding == proto::Frame::H264) encoding = proto::Frame::JPEG;
    MOTE_ASSIGN_OR_RETURN(auto payload,
                          encoding == proto::Frame::ZSTD ? lossless_.encode(picture) : encodeJpeg(picture));
    return EncodedPicture{encoding, false, std::move(payload)};
}

Result<EncodedPicture> FrameEncoder::encodeH264(const render::Picture& picture,
                                                const EncodingTarget& target) {
    const std::size_t most = target.frameBytes.value_or(unmeasuredFrameBytes);
    MOTE_ASSIGN_OR_RETURN(auto made, h264_.encode(picture, most, keyWanted_.exchange(false)));
    return EncodedPicture{proto::Frame::H264, made.key, std::move(made.payload)};
}

}  // namespace mote::server
