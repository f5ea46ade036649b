// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/film/film_thumbnails.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "client/view/film/thumbnail.h"

namespace mote::client {

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
