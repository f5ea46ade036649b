// SPDX-License-Identifier: GPL-3.0-or-later
//
// FilmThumbnails: the small pictures of a film's keyframes, as OpenGL textures, by their numbers. Owned by
// the film's editor; main thread, with the window's context current.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "client/shared/decode.h"
#include "client/view/film/film_model.h"
#include "client/view/window.h"

namespace mote::client {

/// A picture made small: the middle of it that has the wanted proportions, averaged. A value; pure
/// functions.
struct Thumbnail {
    std::uint32_t width = 0;           ///< pixels
    std::uint32_t height = 0;          ///< pixels
    std::vector<std::uint8_t> pixels;  ///< RGBA, sRGB-encoded, row 0 on top
};

/// Makes a thumbnail of a picture of 4 * width * height bytes, RGBA, row 0 on top. Nothing of it is empty;
/// one that is smaller is made larger.
Thumbnail makeThumbnail(std::span<const std::uint8_t> picture, std::uint32_t width, std::uint32_t height,
                        std::uint32_t smallWidth, std::uint32_t smallHeight);

class FilmThumbnails {
  public:
    /// As many are kept; keyframes beyond are shown by their number.
    static constexpr std::size_t most = 256;

    bool has(std::uint64_t picture) const { return textures_.count(picture) != 0; }
    bool full() const { return textures_.size() >= most; }
    /// Made from a picture of SRGB8, cut to the film's proportions. Ignored if it has none, or there are
    /// enough.
    void put(std::uint64_t picture, const FramePixels& pixels, FilmSize film);
    /// What Dear ImGui calls it; null if there is none.
    void* handle(std::uint64_t picture) const;
    /// Drops those of keyframes that are gone.
    void keepOnly(const FilmModel& film);

  private:
    std::map<std::uint64_t, std::unique_ptr<PictureTexture>> textures_;
};

/// Pixels of a thumbnail of a film.
FilmSize thumbnailSize(FilmSize film);

}  // namespace mote::client
