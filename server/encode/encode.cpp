// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/encode.h"

#include <turbojpeg.h>
#include <zstd.h>

#include <memory>
#include <new>

#include "protocol/wire/row_filter.h"

namespace mote::server {
namespace {

struct DestroyJpeg {
    void operator()(void* handle) const { tjDestroy(handle); }
};
struct FreeJpeg {
    void operator()(unsigned char* bytes) const { tjFree(bytes); }
};
struct FreeZstd {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};

/// Memory that is written before it is read: not worth clearing.
using Scratch = std::unique_ptr<std::uint8_t[]>;
Scratch makeScratch(std::size_t size) {
    return std::make_unique_for_overwrite<std::uint8_t[]>(size);
}

Error outOfMemory() {
    return {ErrorCode::resourceExhausted, "frame", "there is not enough memory to encode the picture"};
}

void checkPicture(const render::Picture& picture) {
    MOTE_CHECK(picture.width != 0 && picture.height != 0);
    MOTE_CHECK(picture.pixels.size() ==
               std::size_t{picture.width} * picture.height * render::bytesPerPixel(picture.format));
}

Result<std::vector<std::uint8_t>> compress(std::span<const std::uint8_t> bytes, int level) {
    const std::unique_ptr<ZSTD_CCtx, FreeZstd> context(ZSTD_createCCtx());
    if (!context) return outOfMemory();
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, level);
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
    const std::size_t bound = ZSTD_compressBound(bytes.size());
    const Scratch packed = makeScratch(bound);
    const std::size_t size = ZSTD_compress2(context.get(), packed.get(), bound, bytes.data(), bytes.size());
    if (ZSTD_isError(size)) return Error{ErrorCode::internal, "frame", ZSTD_getErrorName(size)};
    return std::vector<std::uint8_t>(packed.get(), packed.get() + size);
}

}  // namespace

proto::PixelFormat wireFormat(render::PixelFormat format) {
    return format == render::PixelFormat::srgb8 ? proto::SRGB8 : proto::LINEAR_HALF;
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

Result<std::vector<std::uint8_t>> encodeLossless(const render::Picture& picture, int level) {
    checkPicture(picture);
    try {
        const proto::PixelFormat format = wireFormat(picture.format);
        const std::size_t size =
            std::size_t{picture.width} * picture.height * wire::filteredPixelSize(format);
        const Scratch filtered = makeScratch(size);
        wire::filterRows(format, picture.width, picture.pixels, {filtered.get(), size});
        return compress({filtered.get(), size}, level);
    } catch (const std::bad_alloc&) {
        return outOfMemory();
    }
}

}  // namespace mote::server
