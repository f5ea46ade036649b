// SPDX-License-Identifier: GPL-3.0-or-later
//
// Picture files: pixels as PNG (libdeflate), EXR (OpenEXR) or JPEG (libjpeg-turbo); SVG, EPS and PDF as the
// server made them. The same pixels and key give the same bytes: no dates, hosts or versions are written. A
// file appears by one rename and is whole then. Functions; any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/shared/decode.h"

namespace mote::client {

enum class PictureFormat {
    png,    ///< RGB, 8 bits, sRGB
    png16,  ///< RGB, 16 bits, sRGB
    exr,    ///< RGB, half floats, linear
    jpg,    ///< RGB, quality 95, 4:4:4, sRGB
    svg,    ///< dots as shapes on a sheet, and so on
    eps,
    pdf,
};

/// "png", "png16", "exr", "jpg", "svg", "eps", "pdf"; empty for other names.
std::optional<PictureFormat> pictureFormat(std::string_view name);
std::string_view name(PictureFormat format);
/// The extension of its files.
std::string_view extension(PictureFormat format);
/// What a server must be asked for; of a document nothing, but a page.
proto::PixelFormat pixelFormat(PictureFormat format);
/// FORMAT_UNSPECIFIED for those of pixels.
proto::Page::Format pageFormat(PictureFormat format);

/// The bytes of a picture file. `key` goes into its description, where readPictureKey finds it: what the
/// picture shows, in hexadecimal digits. Errors: unsupported (pixels of another format), internal.
Result<std::vector<std::uint8_t>> encodePicture(const FramePixels& pixels, PictureFormat format,
                                                std::string_view key);

/// A whole file, or none: nothing is left after a failure. Errors: as PartFile's, with the file's name.
Status writeFile(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes);

/// The key of a picture that mote-frames wrote; empty if there is none, or where the file is not whole:
/// all its pixels are read and its size is `width` x `height`. Of a document only the end is looked at.
std::optional<std::string> readPictureKey(const std::filesystem::path& path, PictureFormat format,
                                          std::uint32_t width, std::uint32_t height);

/// A picture file that mote-frames wrote, as SRGB8. Errors: notFound (there is none, or no picture), corrupt,
/// unsupported (linear pixels).
Result<FramePixels> readPictureFrame(const std::filesystem::path& path);

}  // namespace mote::client
