// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/encode.h"

#include <turbojpeg.h>

#include <memory>

#include "protocol/scene/mote_check.h"

namespace mote::server {
namespace {

struct DestroyJpeg {
    void operator()(void* handle) const { tjDestroy(handle); }
};
struct FreeJpeg {
    void operator()(unsigned char* bytes) const { tjFree(bytes); }
};
Error outOfMemory() {
    return {ErrorCode::resourceExhausted, "frame", "there is not enough memory to encode the picture"};
}

}  // namespace

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

}  // namespace mote::server
