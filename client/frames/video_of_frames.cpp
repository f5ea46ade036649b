// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/video_of_frames.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <optional>

#include "client/frames/video/palette_maker.h"
#include "client/frames/video/video_writer.h"
#include "protocol/scene/view.h"

namespace mote::client {
namespace {

Result<FramePixels> checkedFrame(const FrameReader& frame, std::size_t index, const VideoSettings& settings) {
    auto pixels = frame(index);
    if (!pixels.ok()) return pixels;
    if (pixels->width == settings.width && pixels->height == settings.height) return pixels;
    return Error{ErrorCode::corrupt, fmt::format("frame {}", index),
                 fmt::format("has {} x {} pixels, and the video {} x {}", pixels->width, pixels->height,
                             settings.width, settings.height)};
}

}  // namespace

Status videoOfFrames(const std::filesystem::path& path, const VideoSettings& settings, std::size_t count,
                     const FrameReader& frame, std::string_view key) {
    std::optional<GifPalette> palette;
    if (settings.format == VideoFormat::gif) {
        PaletteMaker maker;
        for (std::size_t i = 0; i < count; ++i) {
            MOTE_ASSIGN_OR_RETURN(const auto pixels, checkedFrame(frame, i, settings));
            maker.add(pixels.bytes);
        }
        palette = maker.make();
    }
    MOTE_ASSIGN_OR_RETURN(const auto writer, VideoWriter::create(path, settings, palette));
    for (std::size_t i = 0; i < count; ++i) {
        MOTE_ASSIGN_OR_RETURN(const auto pixels, checkedFrame(frame, i, settings));
        MOTE_RETURN_IF_ERROR(writer->add(pixels.bytes));
    }
    return writer->finish(key);
}

Result<FramePixels> readPictureFrame(const std::filesystem::path& path) {
    const auto input = OIIO::ImageInput::open(path.string());
    if (!input) {
        OIIO::geterror();  // taken, or the library prints it at exit
        return Error{ErrorCode::notFound, path.string(), "is no picture"};
    }
    const auto& spec = input->spec();
    const bool sized = spec.width >= 1 && spec.height >= 1 && spec.width <= static_cast<int>(View::maxSide) &&
                       spec.height <= static_cast<int>(View::maxSide) && spec.nchannels == 3;
    if (!sized) return Error{ErrorCode::corrupt, path.string(), "is no picture of mote-frames"};
    if (spec.format == OIIO::TypeDesc::HALF)
        return Error{ErrorCode::unsupported, path.string(),
                     "a video is made of png or jpg, not of linear pixels"};
    FramePixels pixels{
        static_cast<std::uint32_t>(spec.width), static_cast<std::uint32_t>(spec.height), proto::SRGB8, {}};
    pixels.bytes.assign(std::size_t{pixels.width} * pixels.height * 4, 255);
    if (input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, pixels.bytes.data(), 4)) return pixels;
    input->geterror();
    return Error{ErrorCode::corrupt, path.string(), "cannot be read to its end"};
}

}  // namespace mote::client
