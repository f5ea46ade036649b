// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/image/bilevel_tiff.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <cstdarg>
#include <memory>
#include <vector>

namespace mote::prep {
namespace {

struct Closer {
    void operator()(TIFF* file) const { TIFFClose(file); }
};
using TiffPtr = std::unique_ptr<TIFF, Closer>;

int dropMessage(TIFF*, void*, const char*, const char*, va_list) {
    return 1;
}

TiffPtr openFile(const std::filesystem::path& path) {
    TIFFOpenOptions* const options = TIFFOpenOptionsAlloc();
    if (options == nullptr) return nullptr;
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, tmsize_t{1} << 30);
    TIFFOpenOptionsSetErrorHandlerExtR(options, dropMessage, nullptr);
    TIFFOpenOptionsSetWarningHandlerExtR(options, dropMessage, nullptr);
    TiffPtr file(TIFFOpenExt(path.c_str(), "rm", options));
    TIFFOpenOptionsFree(options);
    return file;
}

}  // namespace

Result<std::optional<storage::Luminance>> readBilevelTiff(const std::filesystem::path& path,
                                                          std::uint64_t mostPixels) {
    const TiffPtr file = openFile(path);
    std::uint16_t bits = 0, samples = 1, meaning = PHOTOMETRIC_MINISBLACK;
    // What cannot be opened is OpenImageIO's to say.
    if (!file || TIFFGetField(file.get(), TIFFTAG_BITSPERSAMPLE, &bits) != 0)
        return std::optional<storage::Luminance>();
    TIFFGetFieldDefaulted(file.get(), TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetField(file.get(), TIFFTAG_PHOTOMETRIC, &meaning);
    const std::string where = path.string();
    if (samples != 1 || meaning > PHOTOMETRIC_MINISBLACK || TIFFIsTiled(file.get()) != 0) {
        return unsupported(where,
                           "does not say how many bits a sample has, and is no picture in black and white");
    }
    storage::Luminance picture;
    TIFFGetField(file.get(), TIFFTAG_IMAGEWIDTH, &picture.width);
    TIFFGetField(file.get(), TIFFTAG_IMAGELENGTH, &picture.height);
    const std::uint64_t pixels = std::uint64_t{picture.width} * picture.height;
    if (pixels == 0) return corrupt(where, "has no pixels");
    if (pixels > mostPixels || picture.width > storage::maxImageSide ||
        picture.height > storage::maxImageSide) {
        return Error{
            ErrorCode::resourceExhausted, where,
            fmt::format("has {} x {} pixels, more than the job may take", picture.width, picture.height)};
    }
    std::vector<unsigned char> row(static_cast<std::size_t>(TIFFScanlineSize64(file.get())));
    if (row.size() * 8 < picture.width) return corrupt(where, "has rows that are too short");
    picture.values.reserve(static_cast<std::size_t>(pixels));
    for (std::uint32_t y = 0; y < picture.height; ++y) {
        if (TIFFReadScanline(file.get(), row.data(), y) < 0) {
            return corrupt(where, fmt::format("its row {} cannot be read", y));
        }
        for (std::uint32_t x = 0; x < picture.width; ++x) {
            const bool bit = (row[x / 8] >> (7 - x % 8) & 1U) != 0;
            picture.values.push_back(bit == (meaning == PHOTOMETRIC_MINISBLACK) ? 1.0F : 0.0F);
        }
    }
    return std::optional(std::move(picture));
}

}  // namespace mote::prep
