// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/shared/decode.h"

#include <fmt/format.h>
#include <turbojpeg.h>
#include <zstd.h>
#include <memory>

#include "protocol/scene/view.h"
#include "protocol/wire/row_filter.h"

namespace mote::client {
namespace {

Status checkSize(const proto::Frame& message) {
    const std::uint64_t width = message.width(), height = message.height();
    const bool sides = width >= 1 && width <= View::maxSide && height >= 1 && height <= View::maxSide;
    if (sides && width * height <= View::maxPixels) return success();
    return corrupt("frame", fmt::format("the server sent a picture of {} x {} pixels", width, height));
}

Result<FramePixels> decodeZstd(FramePixels pixels, std::span<const std::uint8_t> payload) {
    const std::size_t count = std::size_t{pixels.width} * pixels.height;
    const std::size_t size = count * wire::filteredPixelSize(pixels.format);
    const auto stated = ZSTD_getFrameContentSize(payload.data(), payload.size());
    if (stated == ZSTD_CONTENTSIZE_ERROR) return corrupt("frame", "the picture's bytes are not zstd");
    if (stated != ZSTD_CONTENTSIZE_UNKNOWN && stated != size) {
        return corrupt("frame",
                       fmt::format("the picture holds {} bytes where its size asks for {}", stated, size));
    }
    const auto filtered = std::make_unique_for_overwrite<std::uint8_t[]>(size);
    const std::size_t got = ZSTD_decompress(filtered.get(), size, payload.data(), payload.size());
    if (ZSTD_isError(got)) {
        return corrupt("frame", fmt::format("the picture is damaged: {}", ZSTD_getErrorName(got)));
    }
    if (got != size) {
        return corrupt("frame",
                       fmt::format("the picture holds {} bytes where its size asks for {}", got, size));
    }
    pixels.bytes.resize(count * bytesPerPixel(pixels.format));
    wire::unfilterRows(pixels.format, pixels.width, {filtered.get(), size}, pixels.bytes);
    return pixels;
}

Result<FramePixels> decodeJpeg(FramePixels pixels, std::span<const std::uint8_t> payload) {
    if (pixels.format != proto::SRGB8) return corrupt("frame", "a JPEG picture cannot hold linear halves");
    const std::unique_ptr<void, int (*)(tjhandle)> jpeg(tjInitDecompress(), tjDestroy);
    if (!jpeg) return Error{ErrorCode::internal, "frame", "libjpeg-turbo does not start"};
    int width = 0, height = 0, subsampling = 0, colorspace = 0;
    if (tjDecompressHeader3(jpeg.get(), payload.data(), payload.size(), &width, &height, &subsampling,
                            &colorspace) != 0) {
        return corrupt("frame", fmt::format("the picture is not JPEG: {}", tjGetErrorStr2(jpeg.get())));
    }
    if (static_cast<std::uint32_t>(width) != pixels.width ||
        static_cast<std::uint32_t>(height) != pixels.height) {
        return corrupt("frame", fmt::format("the JPEG picture is {} x {}, its message says {} x {}", width,
                                            height, pixels.width, pixels.height));
    }
    pixels.bytes.resize(std::size_t{pixels.width} * pixels.height * 4);
    // A warning (a truncated file, say) counts as damage: half a picture is a wrong picture.
    if (tjDecompress2(jpeg.get(), payload.data(), payload.size(), pixels.bytes.data(), width, 0, height,
                      TJPF_RGBA, 0) != 0) {
        return corrupt("frame", fmt::format("the picture is damaged: {}", tjGetErrorStr2(jpeg.get())));
    }
    return pixels;
}

}  // namespace

std::size_t bytesPerPixel(proto::PixelFormat format) {
    return wire::pixelSize(format);
}

Result<FramePixels> decodeFrame(const proto::Frame& message, std::span<const std::uint8_t> payload) {
    MOTE_RETURN_IF_ERROR(checkSize(message));
    FramePixels pixels{message.width(), message.height(), message.format(), {}};
    if (message.encoding() == proto::Frame::DOCUMENT) {
        pixels.format = proto::PIXEL_FORMAT_UNSPECIFIED;
        pixels.bytes.assign(payload.begin(), payload.end());
        return pixels;
    }
    if (pixels.format == proto::PIXEL_FORMAT_UNSPECIFIED) pixels.format = proto::SRGB8;
    if (bytesPerPixel(pixels.format) == 0) {
        return Error{ErrorCode::unsupported, "frame",
                     "the server sent a pixel format that is not known here"};
    }
    switch (message.encoding()) {
        case proto::Frame::JPEG:
            return decodeJpeg(std::move(pixels), payload);
        case proto::Frame::ZSTD:
            return decodeZstd(std::move(pixels), payload);
        default:
            return Error{ErrorCode::unsupported, "frame",
                         "the server sent an encoding that is not known here"};
    }
}

Result<FramePixels> FrameDecoder::decode(const proto::Frame& message, std::span<const std::uint8_t> payload) {
    if (message.encoding() != proto::Frame::H264) return decodeFrame(message, payload);
    wantsKey_ = true;
    MOTE_RETURN_IF_ERROR(checkSize(message));
    if (message.format() != proto::SRGB8)
        return corrupt("frame", "an H.264 picture cannot hold linear halves");
    auto pixels = h264_.decode(message.width(), message.height(), message.key(), payload);
    wantsKey_ = !pixels.ok();
    return pixels;
}

}  // namespace mote::client
