// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/client/film_reader.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <stdexcept>

#include "tests/support/random.h"

namespace mote::test {
namespace {

void check(bool holds, const char* what) {
    if (!holds) throw std::runtime_error(what);
}

std::string orNone(const char* text) {
    return text ? text : "none";
}

/// The standard's own formula, by floating point: what our integers are held against.
Rgba fromYcc(const AVFrame& frame) {
    const bool full = frame.format == AV_PIX_FMT_YUV444P;
    check(full || frame.format == AV_PIX_FMT_YUV420P, "another pixel format");
    Rgba rgba(std::size_t{4} * static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height),
              255);
    const auto sample = [&](int plane, int x, int y) {
        return 0.0 + frame.data[plane][y * frame.linesize[plane] + x];
    };
    const auto byte = [](double v) {
        return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0, 255.0)));
    };
    for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
            const int half = full ? 1 : 2;
            const double luma = (sample(0, x, y) - 16) * 255 / 219;
            const double cb = (sample(1, x / half, y / half) - 128) * 255 / 224;
            const double cr = (sample(2, x / half, y / half) - 128) * 255 / 224;
            const double r = luma + 1.5748 * cr, b = luma + 1.8556 * cb;
            auto* pixel = rgba.data() + 4 * (std::size_t(y) * std::size_t(frame.width) + std::size_t(x));
            pixel[0] = byte(r);
            pixel[1] = byte((luma - 0.2126 * r - 0.0722 * b) / 0.7152);
            pixel[2] = byte(b);
        }
    }
    return rgba;
}

Rgba fromBgra(const AVFrame& frame) {
    Rgba rgba;
    for (int y = 0; y < frame.height; ++y) {
        const std::uint8_t* row = frame.data[0] + y * frame.linesize[0];
        for (int x = 0; x < frame.width; ++x) {
            check(row[4 * x + 3] == 255, "a pixel that shows what is behind the film");
            rgba.insert(rgba.end(), {row[4 * x + 2], row[4 * x + 1], row[4 * x], 255});
        }
    }
    return rgba;
}

struct Reader {
    explicit Reader(const std::filesystem::path& path) {
        av_log_set_level(AV_LOG_QUIET);
        check(avformat_open_input(&input, ("file:" + path.string()).c_str(), nullptr, nullptr) == 0,
              "not a film");
        check(avformat_find_stream_info(input, nullptr) >= 0 && input->nb_streams == 1, "not one stream");
        stream = input->streams[0];
        const AVCodec* codec = avcodec_find_decoder(stream->codecpar->codec_id);
        context = avcodec_alloc_context3(codec);
        check(avcodec_parameters_to_context(context, stream->codecpar) >= 0, "no decoder");
        context->err_recognition = AV_EF_EXPLODE;
        check(avcodec_open2(context, codec, nullptr) == 0, "the decoder does not open");
        film.codec = codec->name;
        film.streamRange = orNone(av_color_range_name(stream->codecpar->color_range));
        film.streamPrimaries = orNone(av_color_primaries_name(stream->codecpar->color_primaries));
        film.streamTransfer = orNone(av_color_transfer_name(stream->codecpar->color_trc));
        film.streamMatrix = orNone(av_color_space_name(stream->codecpar->color_space));
    }
    ~Reader() {
        av_packet_free(&packet);
        av_frame_free(&frame);
        avcodec_free_context(&context);
        avformat_close_input(&input);
    }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;

    void take() {
        while (avcodec_receive_frame(context, frame) == 0) {
            check((frame->flags & AV_FRAME_FLAG_CORRUPT) == 0, "a damaged frame");
            film.width = static_cast<std::uint32_t>(frame->width);
            film.height = static_cast<std::uint32_t>(frame->height);
            film.pixelFormat = orNone(av_get_pix_fmt_name(static_cast<AVPixelFormat>(frame->format)));
            film.range = orNone(av_color_range_name(frame->color_range));
            film.primaries = orNone(av_color_primaries_name(frame->color_primaries));
            film.transfer = orNone(av_color_transfer_name(frame->color_trc));
            film.matrix = orNone(av_color_space_name(frame->colorspace));
            film.times.push_back(static_cast<double>(frame->best_effort_timestamp) *
                                 av_q2d(stream->time_base));
            film.frames.push_back(frame->format == AV_PIX_FMT_BGRA ? fromBgra(*frame) : fromYcc(*frame));
        }
    }

    void all() {
        while (av_read_frame(input, packet) == 0) {
            check(avcodec_send_packet(context, packet) == 0, "a damaged packet");
            film.duration = static_cast<double>(packet->pts + packet->duration) * av_q2d(stream->time_base);
            av_packet_unref(packet);
            take();
        }
        avcodec_send_packet(context, nullptr);
        take();
    }

    Film film;
    AVFormatContext* input = nullptr;
    AVStream* stream = nullptr;
    AVCodecContext* context = nullptr;
    AVFrame* frame = av_frame_alloc();
    AVPacket* packet = av_packet_alloc();
};

std::uint8_t encoded(double light) {
    return static_cast<std::uint8_t>(std::lround(255 * std::pow(std::clamp(light, 0.0, 1.0), 1 / 2.2)));
}

}  // namespace

Film readFilm(const std::filesystem::path& path) {
    Reader reader(path);
    reader.all();
    return std::move(reader.film);
}

std::vector<std::uint8_t> bytesOf(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t entriesOf(const std::filesystem::path& folder) {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator{}));
}

double psnr(const std::vector<Rgba>& a, const std::vector<Rgba>& b) {
    check(a.size() == b.size() && !a.empty(), "another number of frames");
    double sum = 0, count = 0;
    for (std::size_t f = 0; f < a.size(); ++f) {
        check(a[f].size() == b[f].size(), "another size");
        for (std::size_t i = 0; i < a[f].size(); ++i) {
            if (i % 4 == 3) continue;
            const double off = 0.0 + a[f][i] - b[f][i];
            sum += off * off;
            ++count;
        }
    }
    return sum == 0 ? 99 : 10 * std::log10(255.0 * 255 * count / sum);
}

std::vector<Rgba> particleFrames(std::uint32_t width, std::uint32_t height, std::size_t count,
                                 unsigned seed) {
    Random random(seed);
    const double w = width, h = height;
    std::vector<std::array<double, 3>> points(std::size_t{width} * height / 2);
    for (auto& point : points) {
        // The sum of three uniform numbers is near enough to a Gaussian.
        for (auto& x : point) x = 0.5 * (random.unit() + random.unit() + random.unit() - 1.5);
    }
    std::vector<Rgba> frames;
    for (std::size_t f = 0; f < count; ++f) {
        const double turn = 0.02 * static_cast<double>(f);
        std::vector<int> hits(std::size_t{width} * height);
        for (const auto& [x, y, z] : points) {
            const double column = w / 2 + 0.6 * w * (x * std::cos(turn) + z * std::sin(turn)),
                         row = h / 2 + 0.6 * h * y;
            if (column >= 0 && row >= 0 && column < w && row < h) {
                ++hits[static_cast<std::size_t>(row) * width + static_cast<std::size_t>(column)];
            }
        }
        Rgba rgba;
        for (std::size_t i = 0; i < hits.size(); ++i) {
            const double x = 3 * (static_cast<double>(i % width) / w - 0.5),
                         y = 3 * (static_cast<double>(i / width) / h - 0.5);
            const double glow = 0.5 * std::exp(-x * x - y * y), cover = 1 - std::pow(0.4, hits[i]);
            rgba.insert(rgba.end(), {encoded(0.9 * glow * (1 - cover) + cover),
                                     encoded(0.4 * glow * glow * (1 - cover) + 0.69 * cover),
                                     encoded(0.3 * glow * (1 - glow) * (1 - cover) + 0.32 * cover), 255});
        }
        frames.push_back(std::move(rgba));
    }
    return frames;
}

Rgba flatFields(std::uint32_t width, std::uint32_t height, std::uint32_t side, unsigned seed) {
    Rgba rgba;
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            Random random(seed, std::uint64_t{y / side} << 32 | x / side);
            for (int c = 0; c < 3; ++c) rgba.push_back(static_cast<std::uint8_t>(random.below(256)));
            rgba.push_back(255);
        }
    }
    return rgba;
}

}  // namespace mote::test
