// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/lossless_encoder.h"

#include <zstd.h>

#include <algorithm>
#include <new>

#include "protocol/wire/row_filter.h"
#include "server/encode/encode.h"

namespace mote::server {
namespace {

// Sampled rows lie together, as zstd packs a row by what it has seen in those above.
constexpr std::size_t sampledRun = 8;       // rows
constexpr std::size_t sampledPeriod = 128;  // from one run to the next

Error outOfMemory() {
    return {ErrorCode::resourceExhausted, "frame", "there is not enough memory to encode the picture"};
}

}  // namespace

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
