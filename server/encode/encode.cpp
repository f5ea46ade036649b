// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/encode.h"

#include <turbojpeg.h>
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <new>

#include "protocol/scene/mote_check.h"
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
        const proto::PixelFormat format = wireFormat(picture.format);
        const std::size_t size =
            std::size_t{picture.width} * picture.height * wire::filteredPixelSize(format);
        wire::filterRows(format, picture.width, picture.pixels, {filtered_.take(size), size});
        MOTE_ASSIGN_OR_RETURN(const auto packed, pack(size));
        return std::vector<std::uint8_t>(packed_.bytes.get(), packed_.bytes.get() + packed);
    } catch (const std::bad_alloc&) {
        return outOfMemory();
    }
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
