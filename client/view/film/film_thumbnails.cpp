// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/film/film_thumbnails.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <set>

#include "protocol/base/mote_check.h"

namespace mote::client {
namespace {

/// Pixels of one direction that are shown.
struct Part {
    std::uint64_t begin, size;

    /// The pixels that the i-th of `count` is made from: at least one.
    std::uint64_t from(std::uint64_t i, std::uint64_t count) const { return begin + i * size / count; }
    std::uint64_t to(std::uint64_t i, std::uint64_t count) const {
        return std::max(begin + (i + 1) * size / count, from(i, count) + 1);
    }
};

/// The middle of `all`, not more than `most`.
Part middle(std::uint64_t all, std::uint64_t most) {
    const auto size = std::clamp(most, std::uint64_t{1}, all);
    return {(all - size) / 2, size};
}

}  // namespace

Thumbnail makeThumbnail(std::span<const std::uint8_t> picture, std::uint32_t width, std::uint32_t height,
                        std::uint32_t smallWidth, std::uint32_t smallHeight) {
    MOTE_CHECK(picture.size() == 4ULL * width * height && width > 0 && height > 0);
    MOTE_CHECK(smallWidth > 0 && smallHeight > 0);
    const Part across = middle(width, std::uint64_t{height} * smallWidth / smallHeight);
    const Part down = middle(height, std::uint64_t{width} * smallHeight / smallWidth);
    Thumbnail small{smallWidth, smallHeight, {}};
    small.pixels.reserve(4ULL * smallWidth * smallHeight);
    for (std::uint32_t y = 0; y < smallHeight; ++y) {
        for (std::uint32_t x = 0; x < smallWidth; ++x) {
            std::array<std::uint64_t, 4> sum{};
            const auto left = across.from(x, smallWidth), right = across.to(x, smallWidth);
            const auto top = down.from(y, smallHeight), bottom = down.to(y, smallHeight);
            for (auto row = top; row < bottom; ++row) {
                const auto* pixel = &picture[4 * (row * width + left)];
                for (std::uint64_t i = 0; i < 4 * (right - left); ++i) sum[i % 4] += pixel[i];
            }
            const auto count = (right - left) * (bottom - top);
            for (const auto value : sum)
                small.pixels.push_back(static_cast<std::uint8_t>((value + count / 2) / count));
        }
    }
    return small;
}

FilmSize thumbnailSize(FilmSize film) {
    constexpr double width = 256.0, height = 144.0;
    if (film.width == 0 || film.height == 0) return {256, 144};
    const double scale = std::min(width / film.width, height / film.height);
    const auto side = [&](std::uint32_t pixels) {
        return static_cast<std::uint32_t>(std::max(std::lround(pixels * scale), 1L));
    };
    return {side(film.width), side(film.height)};
}

void FilmThumbnails::put(std::uint64_t picture, const FramePixels& pixels, FilmSize film) {
    if (pixels.format != proto::SRGB8 || pixels.width == 0 || pixels.height == 0) return;
    if (full() && !has(picture)) return;
    auto& texture = textures_[picture];
    if (!texture) texture = std::make_unique<PictureTexture>();
    const auto size = thumbnailSize(film);
    const auto small = makeThumbnail(pixels.bytes, pixels.width, pixels.height, size.width, size.height);
    texture->upload(small.pixels, small.width, small.height);
}

void* FilmThumbnails::handle(std::uint64_t picture) const {
    const auto found = textures_.find(picture);
    return found == textures_.end() ? nullptr : found->second->handle();
}

void FilmThumbnails::keepOnly(const FilmModel& film) {
    std::set<std::uint64_t> wanted;
    for (const auto& keyframe : film.keyframes()) wanted.insert(keyframe.picture);
    std::erase_if(textures_, [&](const auto& entry) { return wanted.count(entry.first) == 0; });
}

}  // namespace mote::client
