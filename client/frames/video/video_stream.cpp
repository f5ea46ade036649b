// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/video/video_stream.h"

extern "C" {
#include <libavutil/opt.h>
}

#include <fmt/format.h>
#include <cmath>
#include <utility>
#include <vector>

#include "client/frames/video/video_settings.h"
#include "protocol/base/system_error.h"

namespace mote::client {

Error libavError(int code, const std::string& where) {
    constexpr int mostErrno = 4095;  // libav's own codes are four letters, far beyond
    const int number = AVUNERROR(code);
    if (number > 0 && number <= mostErrno) return systemError(number, where, "cannot be written");
    char text[AV_ERROR_MAX_STRING_SIZE] = {};
    av_strerror(code, text, sizeof text);
    return {ErrorCode::internal, where, fmt::format("the film cannot be encoded: {}", text)};
}

namespace {

constexpr int mostRateTerm = 1'001'000;  // 30000/1001 and any decimal of three digits are exact
constexpr int threads = 2;               // of the encoder: part of what its bytes depend on
constexpr double keySeconds = 2;         // between frames that a player can jump to

AVPixelFormat pixelFormat(const VideoSettings& settings) {
    if (settings.format == VideoFormat::gif) return AV_PIX_FMT_PAL8;
    return settings.chroma == VideoChroma::full ? AV_PIX_FMT_YUV444P : AV_PIX_FMT_YUV420P;
}

using Options = std::vector<std::pair<const char*, std::string>>;

/// Chosen by docs/PERFORMANCE.md, "Videos". H.264: the fastest preset; without psychovisual tuning, which
/// takes bits from colour; a quantizer that does not rise where there is much detail (qcomp), rounds almost
/// to the nearest (deadzone), and drops no coefficient for being small (decimate), so that flat colours are
/// exact.
Options encoderOptions(const VideoSettings& settings) {
    const auto crf = fmt::format("{}", settings.quality.value_or(defaultQuality(settings.format)));
    switch (settings.format) {
        case VideoFormat::mp4:
            return {{"preset", "ultrafast"},
                    {"tune", "psnr"},
                    {"crf", crf},
                    {"x264-params",
                     "cpu-independent=1:qcomp=1:no-dct-decimate=1:deadzone-inter=6:deadzone-intra=6"}};
        case VideoFormat::webm:
            // "good" takes seven times as long for 5% fewer bytes.
            return {{"deadline", "realtime"},
                    {"cpu-used", "8"},
                    {"row-mt", "1"},
                    {"tile-columns", "1"},
                    {"crf", crf}};
        case VideoFormat::gif:
            return {};  // by itself: only what changes, between frames that lie as they lay
    }
    return {};
}

/// Code values of sRGB are kept; players show BT.709 as they are shown.
void describeColors(AVCodecContext& context, VideoChroma chroma) {
    context.color_range = AVCOL_RANGE_MPEG;
    context.color_primaries = AVCOL_PRI_BT709;
    context.color_trc = AVCOL_TRC_BT709;
    context.colorspace = AVCOL_SPC_BT709;
    if (chroma == VideoChroma::halved) context.chroma_sample_location = AVCHROMA_LOC_LEFT;
}

void describe(AVCodecContext& context, const VideoSettings& settings, AVRational rate) {
    context.width = static_cast<int>(settings.width);
    context.height = static_cast<int>(settings.height);
    context.pix_fmt = pixelFormat(settings);
    context.flags |= AV_CODEC_FLAG_BITEXACT;
    context.thread_count = threads;
    if (settings.format == VideoFormat::gif) {
        context.time_base = {1, 100};
        return;
    }
    context.time_base = av_inv_q(rate);
    context.framerate = rate;
    context.gop_size = static_cast<int>(std::ceil(keySeconds * av_q2d(rate)));
    context.max_b_frames = 0;
    context.bit_rate = 0;  // whatever the quality takes
    describeColors(context, settings.chroma);
}

}  // namespace

VideoStream::VideoStream(std::string where, const VideoSettings& settings)
    : where_(std::move(where)),
      settings_(settings),
      rate_(av_d2q(settings.fps, mostRateTerm)),
      frame_(av_frame_alloc()),
      packet_(av_packet_alloc()) {}

Error VideoStream::failed(int code) const {
    return libavError(code, where_);
}

Result<std::unique_ptr<VideoStream>> VideoStream::open(const std::filesystem::path& file, std::string where,
                                                       const VideoSettings& settings) {
    av_log_set_level(AV_LOG_QUIET);  // what fails is told by an Error
    std::unique_ptr<VideoStream> stream(new VideoStream(std::move(where), settings));
    if (!stream->frame_ || !stream->packet_) return stream->failed(AVERROR(ENOMEM));
    MOTE_RETURN_IF_ERROR(stream->openEncoder());
    MOTE_RETURN_IF_ERROR(stream->openFile(file));
    return stream;
}

Status VideoStream::openEncoder() {
    const auto& made = videoCodec(settings_.format);
    const AVCodec* codec = avcodec_find_encoder_by_name(made.encoder);
    if (!codec) {
        return Error{ErrorCode::unsupported, where_, fmt::format("libavcodec has no {} here", made.encoder)};
    }
    encoder_.reset(avcodec_alloc_context3(codec));
    if (!encoder_) return failed(AVERROR(ENOMEM));
    describe(*encoder_, settings_, rate_);
    const AVOutputFormat* container = av_guess_format(made.container, nullptr, nullptr);
    if (container && (container->flags & AVFMT_GLOBALHEADER)) encoder_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    for (const auto& [name, value] : encoderOptions(settings_)) {
        if (const int code = av_opt_set(encoder_->priv_data, name, value.c_str(), 0); code < 0)
            return failed(code);
    }
    if (avcodec_open2(encoder_.get(), codec, nullptr) < 0) {
        return Error{ErrorCode::unsupported, where_,
                     fmt::format("{} takes no film of {} x {} pixels at {} frames a second", made.encoder,
                                 settings_.width, settings_.height, settings_.fps)};
    }
    frame_->format = encoder_->pix_fmt;
    frame_->width = encoder_->width;
    frame_->height = encoder_->height;
    frame_->color_range = encoder_->color_range;
    frame_->color_primaries = encoder_->color_primaries;
    frame_->color_trc = encoder_->color_trc;
    frame_->colorspace = encoder_->colorspace;
    frame_->chroma_location = encoder_->chroma_sample_location;
    const int code = av_frame_get_buffer(frame_.get(), 0);
    return code < 0 ? Status(failed(code)) : success();
}

Status VideoStream::openFile(const std::filesystem::path& file) {
    const auto url = "file:" + file.string();  // whatever characters it has
    AVFormatContext* context = nullptr;
    const char* container = videoCodec(settings_.format).container;
    if (const int code = avformat_alloc_output_context2(&context, nullptr, container, url.c_str());
        code < 0) {
        return failed(code);
    }
    output_.reset(context);
    context->flags |= AVFMT_FLAG_BITEXACT;
    AVStream* stream = avformat_new_stream(context, nullptr);
    if (!stream) return failed(AVERROR(ENOMEM));
    stream->time_base = encoder_->time_base;
    stream->avg_frame_rate = rate_;
    if (const int code = avcodec_parameters_from_context(stream->codecpar, encoder_.get()); code < 0) {
        return failed(code);
    }
    if (const int code = avio_open(&context->pb, url.c_str(), AVIO_FLAG_WRITE); code < 0) return failed(code);
    // The index before the pictures: browsers begin to play before all is there.
    if (settings_.format == VideoFormat::mp4) av_opt_set(context->priv_data, "movflags", "+faststart", 0);
    if (settings_.format == VideoFormat::gif) av_opt_set_int(context->priv_data, "loop", 0, 0);  // for ever
    const int code = avformat_write_header(context, nullptr);
    open_ = code >= 0;
    return code < 0 ? Status(failed(code)) : success();
}

/// libavformat's GIF keeps a packet until its end is written, and frees it nowhere else.
VideoStream::~VideoStream() {
    if (open_ && settings_.format == VideoFormat::gif) av_write_trailer(output_.get());
}

Result<AVFrame*> VideoStream::frame() {
    if (const int code = av_frame_make_writable(frame_.get()); code < 0) return failed(code);
    return frame_.get();
}

std::int64_t VideoStream::timeOf(std::int64_t index) const {
    return av_rescale_q(index, av_inv_q(rate_), encoder_->time_base);
}

Status VideoStream::encode() {
    frame_->pts = timeOf(frames_++);
    return send(frame_.get());
}

Status VideoStream::send(const AVFrame* frame) {
    int code = avcodec_send_frame(encoder_.get(), frame);
    while (code >= 0) {
        code = avcodec_receive_packet(encoder_.get(), packet_.get());
        if (code >= 0) MOTE_RETURN_IF_ERROR(write(*packet_));
    }
    const bool done = code == AVERROR(EAGAIN) || code == AVERROR_EOF;
    return done ? success() : Status(failed(code));
}

Status VideoStream::write(AVPacket& packet) {
    // By the frame's number: hundredths of a second are not all alike.
    const auto next = av_rescale_q(packet.pts, encoder_->time_base, av_inv_q(rate_)) + 1;
    packet.duration = timeOf(next) - packet.pts;
    packet.stream_index = 0;
    av_packet_rescale_ts(&packet, encoder_->time_base, output_->streams[0]->time_base);
    const int code = av_interleaved_write_frame(output_.get(), &packet);
    if (output_->pb->error < 0) return failed(output_->pb->error);
    return code < 0 ? Status(failed(code)) : success();
}

Status VideoStream::finish() {
    MOTE_RETURN_IF_ERROR(send(nullptr));
    if (settings_.format == VideoFormat::gif) {
        av_opt_set_int(output_->priv_data, "final_delay", timeOf(frames_) - timeOf(frames_ - 1), 0);
    }
    open_ = false;
    int code = av_write_trailer(output_.get());
    if (code >= 0) code = output_->pb->error;
    const int closed = avio_closep(&output_->pb);
    if (code >= 0) code = closed;
    return code < 0 ? Status(failed(code)) : success();
}

}  // namespace mote::client
