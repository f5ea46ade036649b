// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/draw_annotations.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <glm/gtc/packing.hpp>

#include "protocol/base/mote_check.h"
#include "protocol/scene/srgb.h"
#include "server/figures/cairo_surface.h"
#include "server/figures/draw_marks.h"

namespace mote::server {
namespace {

/// A pixel of Cairo's: opacity in the highest byte, then red, green, blue, times the opacity.
struct Overlay {
    std::uint32_t pixel;

    std::uint32_t opacity() const { return pixel >> 24; }
    std::uint32_t channel(unsigned index) const { return (pixel >> (16 - 8 * index)) & 0xffU; }
};

void mixEncoded(const Overlay& over, std::uint8_t* pixel) {
    const std::uint32_t left = 255 - over.opacity();
    for (unsigned c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>(std::min(255U, over.channel(c) + (pixel[c] * left + 127) / 255));
}

void mixLinear(const Overlay& over, std::uint8_t* pixel) {
    const double opacity = over.opacity() / 255.0;
    for (unsigned c = 0; c < 3; ++c) {
        std::uint16_t bits = 0;
        std::uint8_t* const half = pixel + c * sizeof bits;
        std::memcpy(&bits, half, sizeof bits);
        const double color = srgbToLinear(std::min(1.0, over.channel(c) / 255.0 / opacity));
        const double mixed =
            opacity * color + (1.0 - opacity) * static_cast<double>(glm::unpackHalf1x16(bits));
        bits = glm::packHalf1x16(static_cast<float>(mixed));
        std::memcpy(half, &bits, sizeof bits);
    }
}

}  // namespace

Status drawAnnotations(const Marks& marks, std::uint32_t width, std::uint32_t height,
                       render::Picture& picture) {
    if (marks.empty()) return success();
    MOTE_CHECK(width > 0 && height > 0);
    const CairoSurface surface(cairo_image_surface_create(
        CAIRO_FORMAT_ARGB32, static_cast<int>(picture.width), static_cast<int>(picture.height)));
    const CairoContext context(cairo_create(surface.get()));
    cairo_scale(context.get(), static_cast<double>(picture.width) / width,
                static_cast<double>(picture.height) / height);
    const Typeface typeface;
    drawMarks(context.get(), marks, typeface, TextAs::outlines);
    if (const auto status = cairo_status(context.get()); status != CAIRO_STATUS_SUCCESS)
        return cairoError(status, "annotations");
    cairo_surface_flush(surface.get());
    const auto* row = cairo_image_surface_get_data(surface.get());
    const auto stride = cairo_image_surface_get_stride(surface.get());
    const std::size_t size = render::bytesPerPixel(picture.format);
    const auto mix = picture.format == render::PixelFormat::srgb8 ? mixEncoded : mixLinear;
    std::uint8_t* pixel = picture.pixels.data();
    for (std::uint32_t y = 0; y < picture.height; ++y, row += stride) {
        for (std::uint32_t x = 0; x < picture.width; ++x, pixel += size) {
            Overlay over{};
            std::memcpy(&over.pixel, row + 4 * std::size_t{x}, 4);
            if (over.opacity() > 0) mix(over, pixel);
        }
    }
    return success();
}

}  // namespace mote::server
