// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/frames/exposure.h"

#include <fmt/format.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "protocol/base/mote_check.h"
#include "protocol/scene/srgb.h"
#include "protocol/scene/view.h"
#include "protocol/scene/view_message.h"

namespace mote::client {
namespace {

constexpr std::size_t channels = 3, stored = 4;  // alpha is one everywhere

/// Linear light of an encoded byte.
const std::array<float, 256>& lightOfByte() {
    static const auto table = [] {
        std::array<float, 256> light{};
        for (std::size_t i = 0; i < light.size(); ++i)
            light[i] = static_cast<float>(srgbToLinear(static_cast<double>(i) / 255.0));
        return light;
    }();
    return table;
}

constexpr std::size_t lightSteps = 1 << 16;  // a 20th of a byte's step where sRGB is steepest

const std::vector<std::uint8_t>& byteOfLight() {
    static const auto table = [] {
        std::vector<std::uint8_t> bytes(lightSteps + 1);
        for (std::size_t i = 0; i <= lightSteps; ++i) {
            const double encoded = linearToSrgb(static_cast<double>(i) / lightSteps);
            bytes[i] = static_cast<std::uint8_t>(std::lround(255.0 * encoded));
        }
        return bytes;
    }();
    return table;
}

std::uint8_t encoded(float light) {
    return byteOfLight()[static_cast<std::size_t>(std::lround(std::clamp(light, 0.0F, 1.0F) * lightSteps))];
}

/// Linear RGBA.
std::vector<float> lightOf(const FramePixels& pixels) {
    const std::size_t values = pixels.bytes.size() / bytesPerPixel(pixels.format) * stored;
    std::vector<float> light(values);
    if (pixels.format == proto::SRGB8) {
        const auto& table = lightOfByte();
        std::transform(pixels.bytes.begin(), pixels.bytes.end(), light.begin(),
                       [&](std::uint8_t byte) { return table[byte]; });
    } else {
        for (std::size_t i = 0; i < values; ++i) {
            half value;
            std::memcpy(&value, &pixels.bytes[i * sizeof(half)], sizeof(half));
            light[i] = value;
        }
    }
    return light;
}

std::vector<std::uint8_t> bytesOf(const std::vector<float>& rgba, proto::PixelFormat format) {
    if (format == proto::SRGB8) {
        std::vector<std::uint8_t> bytes(rgba.size());
        std::transform(rgba.begin(), rgba.end(), bytes.begin(), encoded);
        return bytes;
    }
    std::vector<std::uint8_t> bytes(rgba.size() * sizeof(half));
    for (std::size_t i = 0; i < rgba.size(); ++i) {
        const half value(rgba[i]);
        std::memcpy(&bytes[i * sizeof(half)], &value, sizeof(half));
    }
    return bytes;
}

}  // namespace

unsigned ExposureSettings::side() const {
    return static_cast<unsigned>(std::lround(std::sqrt(samples)));
}

Status checkExposure(const ExposureSettings& settings) {
    constexpr std::array known{1U, 4U, 9U, 16U};
    if (std::find(known.begin(), known.end(), settings.samples) == known.end())
        return invalid("samples", fmt::format("a pixel has 1, 4, 9 or 16 samples, not {}", settings.samples));
    if (!(settings.shutterDegrees >= 0.0 && settings.shutterDegrees <= 360.0))
        return invalid("shutter", "is an angle from 0 to 360 degrees");
    if (settings.subframes < 1 || settings.subframes > 64)
        return invalid("subframes", fmt::format("there are 1 to 64 of them, not {}", settings.subframes));
    return success();
}

Result<std::vector<proto::View>> viewsOf(const Film& film, std::size_t frame,
                                         const ExposureSettings& settings) {
    std::vector<proto::View> views;
    if (settings.blurs() && !film.continuous()) {
        return Error{ErrorCode::unsupported, "shutter",
                     "motion is blurred only where it is known: in keyframes and moves, not in single views"};
    }
    if (!settings.blurs()) views.push_back(film.frame(frame));
    const double open = settings.shutterDegrees / 360.0 / film.fps();
    for (unsigned i = 0; views.size() < settings.views(); ++i)
        views.push_back(film.at(film.secondsOf(frame) + open * i / settings.subframes));
    if (settings.samples == 1) return views;
    for (auto& view : views) {
        MOTE_ASSIGN_OR_RETURN(const auto parsed, parseView(view));
        const auto larger = magnified(parsed, settings.side());
        if (!larger.ok()) {
            return Error{
                larger.error().code, "samples",
                fmt::format("with {} samples a pixel: {}", settings.samples, larger.error().toString())};
        }
        view = toProto(*larger);
    }
    return views;
}

FramePixels asBytes(FramePixels pixels) {
    if (pixels.format == proto::SRGB8) return pixels;
    return {pixels.width, pixels.height, proto::SRGB8, bytesOf(lightOf(pixels), proto::SRGB8)};
}

void Exposure::begin(const FramePixels& pixels) {
    MOTE_CHECK(pixels.width % side_ == 0 && pixels.height % side_ == 0);
    first_ = {pixels.width / side_, pixels.height / side_, pixels.format, {}};
    sums_.assign(std::size_t{first_.width} * first_.height * channels, 0.0F);
}

void Exposure::add(FramePixels pixels) {
    const bool alone = ++count_ == 1 && side_ == 1;
    if (alone) {
        first_ = std::move(pixels);
        return;
    }
    if (sums_.empty() && side_ == 1) {
        const auto first = std::move(first_);
        begin(first);
        accumulate(first);
    }
    if (sums_.empty()) begin(pixels);
    accumulate(pixels);
}

void Exposure::accumulate(const FramePixels& pixels) {
    MOTE_CHECK(pixels.width == first_.width * side_ && pixels.height == first_.height * side_ &&
               pixels.format == first_.format);
    const auto light = lightOf(pixels);
    for (std::size_t y = 0; y < pixels.height; ++y) {
        float* const row = &sums_[y / side_ * first_.width * channels];
        const float* from = &light[y * pixels.width * stored];
        for (std::size_t x = 0; x < pixels.width; ++x, from += stored) {
            float* const sum = row + x / side_ * channels;
            for (std::size_t c = 0; c < channels; ++c) sum[c] += from[c];
        }
    }
}

FramePixels Exposure::take() {
    if (sums_.empty()) return std::move(first_);
    const float share = 1.0F / static_cast<float>(count_ * side_ * side_);
    std::vector<float> rgba(sums_.size() / channels * stored, 1.0F);
    for (std::size_t i = 0; i < sums_.size() / channels; ++i) {
        for (std::size_t c = 0; c < channels; ++c) rgba[i * stored + c] = sums_[i * channels + c] * share;
    }
    first_.bytes = bytesOf(rgba, first_.format);
    return std::move(first_);
}

}  // namespace mote::client
