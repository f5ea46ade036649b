// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/bench/video/plain_encoder.h"

extern "C" {
#include <libavutil/opt.h>
}

#include <sys/resource.h>

#include <stdexcept>

#include "client/frames/video/video_colors.h"
#include "client/frames/video/video_stream.h"

namespace mote::bench {
namespace {

using namespace client;

void check(bool holds, const std::string& what) {
    if (!holds) throw std::runtime_error("bench-video: " + what);
}

CodecOwner openEncoder(const VideoSettings& settings, const std::string& name, const std::string& options) {
    const AVCodec* codec = avcodec_find_encoder_by_name(name.c_str());
    check(codec != nullptr, "there is no " + name);
    CodecOwner encoder(avcodec_alloc_context3(codec));
    encoder->width = static_cast<int>(settings.width);
    encoder->height = static_cast<int>(settings.height);
    encoder->pix_fmt = settings.chroma == VideoChroma::full ? AV_PIX_FMT_YUV444P : AV_PIX_FMT_YUV420P;
    encoder->time_base = {1, 30};
    encoder->framerate = {30, 1};
    encoder->thread_count = 2;
    encoder->color_range = AVCOL_RANGE_MPEG;
    encoder->colorspace = AVCOL_SPC_BT709;
    encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    AVDictionary* entries = nullptr;
    av_dict_parse_string(&entries, options.c_str(), "=", ":", 0);
    const bool opened = avcodec_open2(encoder.get(), codec, &entries) >= 0;
    const bool known = av_dict_count(entries) == 0;
    av_dict_free(&entries);
    check(opened && known, name + " does not know " + options);
    return encoder;
}

OutputOwner openFile(const std::filesystem::path& file, const AVCodecContext& encoder) {
    AVFormatContext* context = nullptr;
    check(avformat_alloc_output_context2(&context, nullptr, nullptr, file.c_str()) >= 0, "no such container");
    OutputOwner output(context);
    AVStream* stream = avformat_new_stream(context, nullptr);
    stream->time_base = encoder.time_base;
    avcodec_parameters_from_context(stream->codecpar, &encoder);
    check(avio_open(&context->pb, file.c_str(), AVIO_FLAG_WRITE) >= 0, "the file cannot be written");
    check(avformat_write_header(context, nullptr) >= 0, "the container does not take it");
    return output;
}

void send(AVCodecContext& encoder, const AVFrame* frame, AVFormatContext& output) {
    PacketOwner packet(av_packet_alloc());
    check(avcodec_send_frame(&encoder, frame) >= 0, "a frame cannot be encoded");
    while (avcodec_receive_packet(&encoder, packet.get()) >= 0) {
        packet->duration = 1;
        av_packet_rescale_ts(packet.get(), encoder.time_base, output.streams[0]->time_base);
        check(av_interleaved_write_frame(&output, packet.get()) >= 0, "a frame cannot be written");
    }
}

}  // namespace

double processorTime() {
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(used.ru_utime) + seconds(used.ru_stime);
}

double encodePlainly(const std::filesystem::path& file, const VideoSettings& settings,
                     const std::string& name, const std::string& options, const Frames& frames) {
    av_log_set_level(AV_LOG_QUIET);
    const auto encoder = openEncoder(settings, name, options);
    const auto output = openFile(file, *encoder);
    FrameOwner frame(av_frame_alloc());
    frame->format = encoder->pix_fmt;
    frame->width = encoder->width;
    frame->height = encoder->height;
    check(av_frame_get_buffer(frame.get(), 0) >= 0, "there is not enough memory");
    const double before = processorTime();
    for (std::size_t i = 0; i < frames.size(); ++i) {
        check(av_frame_make_writable(frame.get()) >= 0, "there is not enough memory");
        const VideoPlanes planes{{frame->data[0], frame->data[1], frame->data[2]},
                                 {frame->linesize[0], frame->linesize[1], frame->linesize[2]}};
        rgbaToVideo(settings.width, frames[i], settings.chroma, planes);
        frame->pts = static_cast<std::int64_t>(i);
        send(*encoder, frame.get(), *output);
    }
    send(*encoder, nullptr, *output);
    check(av_write_trailer(output.get()) >= 0, "the file cannot be written");
    return processorTime() - before;
}

}  // namespace mote::bench
