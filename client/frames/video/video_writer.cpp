// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/video/video_writer.h"

#include <cstring>

#include "client/frames/video/video_colors.h"
#include "client/frames/video/video_settings.h"
#include "client/frames/video/video_stream.h"
#include "client/shared/part_file.h"

namespace mote::client {
namespace {

/// libav's own order: alpha, R, G and B from the highest byte of a word down. All entries but the last that
/// is used are opaque.
void fillPalette(AVFrame& frame, const GifPalette& palette) {
    std::array<std::uint32_t, AVPALETTE_COUNT> words{};
    words.fill(0xff000000U);
    for (std::size_t i = 0; i < palette.colors.size(); ++i) {
        const auto& [r, g, b] = palette.colors[i];
        words[i] |= std::uint32_t{r} << 16 | std::uint32_t{g} << 8 | b;
    }
    words[GifPalette::mostColors] = 0;  // transparent
    std::memcpy(frame.data[1], words.data(), sizeof words);
}

}  // namespace

class VideoWriter::Impl {
  public:
    Impl(std::string where, const VideoSettings& settings, const std::optional<GifPalette>& palette,
         std::unique_ptr<PartFile> part, std::unique_ptr<VideoStream> stream)
        : where_(std::move(where)),
          settings_(settings),
          palette_(palette),
          part_(std::move(part)),
          stream_(std::move(stream)) {
        if (palette_) dither_.emplace(*palette_);
    }

    Status add(std::span<const std::uint8_t> rgba) {
        MOTE_CHECK(rgba.size() == std::size_t{4} * settings_.width * settings_.height);
        MOTE_ASSIGN_OR_RETURN(AVFrame* const frame, stream_->frame());
        if (dither_) {
            fillIndices(rgba, *frame);
        } else {
            const VideoPlanes planes{{frame->data[0], frame->data[1], frame->data[2]},
                                     {frame->linesize[0], frame->linesize[1], frame->linesize[2]}};
            rgbaToVideo(settings_.width, rgba, settings_.chroma, planes);
        }
        ++frames_;
        return stream_->encode();
    }

    Status finish(std::string_view key) {
        if (frames_ == 0) return Error{ErrorCode::invalidArgument, where_, "a film needs a frame"};
        MOTE_RETURN_IF_ERROR(stream_->finish());
        if (!key.empty()) {
            const auto tail = videoTail(settings_.format, key);
            MOTE_RETURN_IF_ERROR(
                part_->append({reinterpret_cast<const std::uint8_t*>(tail.data()), tail.size()}));
        }
        return part_->publish();
    }

  private:
    void fillIndices(std::span<const std::uint8_t> rgba, AVFrame& frame) {
        const std::size_t rowBytes = std::size_t{4} * settings_.width;
        for (std::uint32_t y = 0; y < settings_.height; ++y) {
            dither_->row(y, rgba.subspan(y * rowBytes, rowBytes),
                         frame.data[0] + static_cast<std::ptrdiff_t>(y) * frame.linesize[0]);
        }
        fillPalette(frame, *palette_);
    }

    std::string where_;  ///< the film's path
    VideoSettings settings_;
    std::optional<GifPalette> palette_;
    std::optional<GifDither> dither_;
    std::unique_ptr<PartFile> part_;  ///< outlives the stream into it
    std::unique_ptr<VideoStream> stream_;
    std::uint64_t frames_ = 0;
};

Result<std::unique_ptr<VideoWriter>> VideoWriter::create(const std::filesystem::path& path,
                                                         const VideoSettings& settings,
                                                         const std::optional<GifPalette>& palette) {
    MOTE_RETURN_IF_ERROR(checkVideo(settings), path.string());
    const bool gif = settings.format == VideoFormat::gif;
    if (gif && (!palette || palette->colors.empty() || palette->colors.size() > GifPalette::mostColors)) {
        return Error{ErrorCode::invalidArgument, path.string(), "a GIF needs a palette of 1 to 255 colours"};
    }
    MOTE_ASSIGN_OR_RETURN(auto part, PartFile::create(path));
    MOTE_ASSIGN_OR_RETURN(auto stream, VideoStream::open(part->hidden(), path.string(), settings));
    auto impl = std::make_unique<Impl>(path.string(), settings, gif ? palette : std::optional<GifPalette>{},
                                       std::move(part), std::move(stream));
    return std::unique_ptr<VideoWriter>(new VideoWriter(std::move(impl)));
}

VideoWriter::VideoWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VideoWriter::~VideoWriter() = default;

Status VideoWriter::add(std::span<const std::uint8_t> rgba) {
    if (!state_.ok()) return state_;
    MOTE_CHECK(impl_ != nullptr);  // not after finish
    state_ = impl_->add(rgba);
    if (!state_.ok()) impl_.reset();
    return state_;
}

Status VideoWriter::finish(std::string_view key) {
    if (!state_.ok()) return state_;
    MOTE_CHECK(impl_ != nullptr);
    state_ = impl_->finish(key);
    impl_.reset();
    return state_;
}

}  // namespace mote::client
