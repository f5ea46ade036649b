// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/encode.h"

#include <turbojpeg.h>
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <new>

#include "protocol/base/mote_check.h"
#include "protocol/wire/row_filter.h"

namespace mote::server {
namespace {

struct DestroyJpeg {
    void operator()(void* handle) const { tjDestroy(handle); }
};
struct FreeJpeg {
    void operator()(unsigned char* bytes) const { tjFree(bytes); }
};

// Sampled rows lie together, as zstd packs a row by what it has seen in those above.
constexpr std::size_t sampledRun = 8;       // rows
constexpr std::size_t sampledPeriod = 128;  // from one run to the next

constexpr std::size_t stripBytes = std::size_t{4} << 20;  // of rows that are filtered together

}  // namespace

Error outOfMemory() {
    return {ErrorCode::resourceExhausted, "frame", "there is not enough memory to encode the picture"};
}

proto::PixelFormat wireFormat(render::PixelFormat format) {
    return format == render::PixelFormat::srgb8 ? proto::SRGB8 : proto::LINEAR_HALF;
}

void checkPicture(const render::Picture& picture) {
    MOTE_CHECK(picture.width != 0 && picture.height != 0);
    MOTE_CHECK(picture.pixels.size() ==
               std::size_t{picture.width} * picture.height * render::bytesPerPixel(picture.format));
}

Result<std::vector<std::uint8_t>> encodeJpeg(const render::Picture& picture, int quality) {
    checkPicture(picture);
    MOTE_CHECK(picture.format == render::PixelFormat::srgb8);
    const std::unique_ptr<void, DestroyJpeg> handle(tjInitCompress());
    if (!handle) return outOfMemory();
    unsigned char* bytes = nullptr;
    unsigned long size = 0;
    const int failed = tjCompress2(handle.get(), picture.pixels.data(), static_cast<int>(picture.width), 0,
                                   static_cast<int>(picture.height), TJPF_RGBX, &bytes, &size, TJSAMP_444,
                                   quality, TJFLAG_FASTDCT);
    const std::unique_ptr<unsigned char, FreeJpeg> owner(bytes);
    if (failed != 0) return Error{ErrorCode::internal, "frame", tjGetErrorStr2(handle.get())};
    return std::vector<std::uint8_t>(bytes, bytes + size);
}

void LosslessEncoder::FreeContext::operator()(ZSTD_CCtx_s* context) const {
    ZSTD_freeCCtx(context);
}

std::uint8_t* LosslessEncoder::Scratch::take(std::size_t wanted) {
    if (wanted > size) {
        bytes = std::make_unique_for_overwrite<std::uint8_t[]>(wanted);
        size = wanted;
    }
    return bytes.get();
}

Status LosslessEncoder::prepare() {
    if (context_) return success();
    context_.reset(ZSTD_createCCtx());
    if (!context_) return outOfMemory();
    ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, level_);
    ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_checksumFlag, 1);
    return success();
}

Result<std::size_t> LosslessEncoder::pack(std::size_t filteredSize) {
    MOTE_RETURN_IF_ERROR(prepare());
    const std::size_t bound = ZSTD_compressBound(filteredSize);
    const std::size_t size =
        ZSTD_compress2(context_.get(), packed_.take(bound), bound, filtered_.bytes.get(), filteredSize);
    if (ZSTD_isError(size)) return Error{ErrorCode::internal, "frame", ZSTD_getErrorName(size)};
    return size;
}

Result<std::vector<std::uint8_t>> LosslessEncoder::encode(const render::Picture& picture) {
    checkPicture(picture);
    try {
        MOTE_RETURN_IF_ERROR(prepare());
        return packRows(picture);
    } catch (const std::bad_alloc&) {
        return outOfMemory();
    }
}

/// Some rows at a time: beside a large picture there is no room for another one of what it becomes.
Result<std::vector<std::uint8_t>> LosslessEncoder::packRows(const render::Picture& picture) {
    const proto::PixelFormat format = wireFormat(picture.format);
    const std::size_t row = std::size_t{picture.width} * wire::filteredPixelSize(format);
    const std::size_t rowBytes = std::size_t{picture.width} * render::bytesPerPixel(picture.format);
    const std::size_t rows = std::clamp<std::size_t>(stripBytes / row, 1, picture.height);
    std::vector<std::uint8_t> packed;
    // Memory that is not written to costs nothing; a list that grows is there twice.
    if (row * picture.height > stripBytes) packed.reserve(ZSTD_compressBound(row * picture.height));
    ZSTD_CCtx_reset(context_.get(), ZSTD_reset_session_only);
    ZSTD_CCtx_setPledgedSrcSize(context_.get(), row * picture.height);
    std::size_t written = 0;
    for (std::size_t y = 0; y < picture.height; y += rows) {
        const std::size_t count = std::min(rows, picture.height - y);
        ZSTD_inBuffer strip{filtered_.take(rows * row), count * row, 0};
        wire::filterRows(format, picture.width,
                         std::span(picture.pixels).subspan(y * rowBytes, count * rowBytes),
                         {filtered_.bytes.get(), count * row});
        const bool last = y + count == picture.height;
        for (std::size_t left = 1; last ? left > 0 : strip.pos < strip.size;) {
            packed.resize(std::max(packed.size(), written + ZSTD_CStreamOutSize()));
            ZSTD_outBuffer out{packed.data(), packed.size(), written};
            left = ZSTD_compressStream2(context_.get(), &out, &strip, last ? ZSTD_e_end : ZSTD_e_continue);
            if (ZSTD_isError(left)) return Error{ErrorCode::internal, "frame", ZSTD_getErrorName(left)};
            written = out.pos;
        }
    }
    packed.resize(written);
    return packed;
}

Result<std::size_t> LosslessEncoder::expectedBytes(const render::Picture& picture) {
    checkPicture(picture);
    try {
        const proto::PixelFormat format = wireFormat(picture.format);
        const std::size_t row = std::size_t{picture.width} * wire::filteredPixelSize(format);
        const std::size_t rowBytes = std::size_t{picture.width} * render::bytesPerPixel(picture.format);
        const std::size_t runs = (picture.height + sampledPeriod - 1) / sampledPeriod;
        std::uint8_t* const filtered = filtered_.take(runs * sampledRun * row);
        std::size_t rows = 0;
        for (std::size_t y = 0; y < picture.height; y += sampledPeriod) {
            const std::size_t count = std::min(sampledRun, picture.height - y);
            wire::filterRows(format, picture.width,
                             std::span(picture.pixels).subspan(y * rowBytes, count * rowBytes),
                             {filtered + rows * row, count * row});
            rows += count;
        }
        const auto packed = pack(rows * row);
        MOTE_RETURN_IF_ERROR(packed);
        return *packed * picture.height / rows;
    } catch (const std::bad_alloc&) {
        return outOfMemory();
    }
}

}  // namespace mote::server
