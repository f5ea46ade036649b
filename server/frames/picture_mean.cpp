// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/frames/picture_mean.h"

#include <array>
#include <bit>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <utility>
#include <vector>

#include "protocol/base/mote_check.h"
#include "protocol/scene/srgb.h"

namespace mote::server {
namespace {

using render::Picture, render::PixelFormat;

constexpr unsigned channels = 4;  // alpha among them, which is 1

/// The numbers of all halves: a picture has millions.
const std::vector<float>& halfValues() {
    static const auto values = [] {
        std::vector<float> all(1 << 16);
        for (unsigned half = 0; half < all.size(); ++half)
            all[half] = glm::unpackHalf1x16(static_cast<std::uint16_t>(half));
        return all;
    }();
    return values;
}

/// SrgbBytes: the nearest of 256 steps of sRGB to a linear number. It is looked up by the first bits of the
/// number, and then the number is compared with where the next steps begin.
class SrgbBytes {
  public:
    SrgbBytes() {
        for (std::size_t step = 1; step < 256; ++step)
            begins_[step] = static_cast<float>(srgbToLinear((static_cast<double>(step) - 0.5) / 255.0));
        begins_[256] = 2.0F;  // beyond all that is looked up
        std::uint8_t step = 0;
        for (std::uint32_t first = 0; first < first_.size(); ++first) {
            const auto least = std::bit_cast<float>(first << shift);
            while (step < 255 && least >= begins_[step + 1U]) ++step;
            first_[first] = step;
        }
    }
    std::uint8_t operator()(float linear) const {
        if (!(linear > 0.0F)) return 0;
        if (linear >= 1.0F) return 255;
        std::uint8_t step = first_[std::bit_cast<std::uint32_t>(linear) >> shift];
        while (linear >= begins_[step + 1U]) ++step;
        return step;
    }

  private:
    static constexpr unsigned shift = 16;
    std::array<float, 257> begins_{};           // the first number of each step
    std::array<std::uint8_t, 0x3f80> first_{};  // of numbers below 1
};

std::uint16_t halfAt(const std::vector<std::uint8_t>& pixels, std::size_t index) {
    std::uint16_t half = 0;
    std::memcpy(&half, pixels.data() + sizeof half * index, sizeof half);
    return half;
}

/// The weighted sum of both, from channel to channel.
template <class Set>
void eachSum(const std::vector<std::uint8_t>& one, float first, const std::vector<std::uint8_t>& other,
             float second, const Set& set) {
    const auto& values = halfValues();
    const std::size_t count = one.size() / sizeof(std::uint16_t);
    for (std::size_t i = 0; i < count; ++i)
        set(i, first * values[halfAt(one, i)] + second * values[halfAt(other, i)]);
}

}  // namespace

void PictureMean::add(Picture picture, double weight) {
    MOTE_CHECK(picture.format == PixelFormat::linearHalf);
    MOTE_CHECK(!latest_ ||
               (picture.width == latest_->picture.width && picture.height == latest_->picture.height &&
                picture.pixels.size() == latest_->picture.pixels.size()));
    if (latest_) join();
    latest_ = Weighted{std::move(picture), weight};
}

/// What is there becomes one picture: their mean by weight.
void PictureMean::join() {
    auto latest = *std::exchange(latest_, std::nullopt);
    if (!sum_) {
        sum_ = std::move(latest);
        return;
    }
    const double all = sum_->weight + latest.weight;
    auto& pixels = sum_->picture.pixels;
    eachSum(pixels, static_cast<float>(sum_->weight / all), latest.picture.pixels,
            static_cast<float>(latest.weight / all), [&](std::size_t i, float value) {
                const std::uint16_t half = glm::packHalf1x16(value);
                std::memcpy(pixels.data() + sizeof half * i, &half, sizeof half);
            });
    sum_->picture.pointsDrawn += latest.picture.pointsDrawn;
    sum_->weight = all;
}

Picture PictureMean::take(PixelFormat format) {
    MOTE_CHECK(sum_ && latest_);
    if (format == PixelFormat::linearHalf) {
        join();
        return std::exchange(sum_, std::nullopt)->picture;
    }
    static const SrgbBytes encode;
    const auto& [first, firstWeight] = *sum_;
    Picture picture{.width = first.width,
                    .height = first.height,
                    .format = format,
                    .pixels = {},
                    .pointsDrawn = first.pointsDrawn + latest_->picture.pointsDrawn};
    picture.pixels.resize(first.pixels.size() / sizeof(std::uint16_t));
    eachSum(first.pixels, static_cast<float>(firstWeight), latest_->picture.pixels,
            static_cast<float>(latest_->weight), [&](std::size_t i, float value) {
                picture.pixels[i] = i % channels == channels - 1 ? 255 : encode(value);
            });
    sum_.reset();
    latest_.reset();
    return picture;
}

std::uint64_t PictureMean::bytes() const {
    return (sum_ ? sum_->picture.pixels.capacity() : 0) + (latest_ ? latest_->picture.pixels.capacity() : 0);
}

}  // namespace mote::server
