// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/figures/cairo_surface.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <string_view>

namespace mote::server {

cairo_status_t appendBytes(void* bytes, const unsigned char* data, unsigned int size) {
    try {
        auto& to = *static_cast<DocumentBytes*>(bytes);
        to.insert(to.end(), data, data + size);
    } catch (const std::bad_alloc&) {
        return CAIRO_STATUS_NO_MEMORY;
    }
    return CAIRO_STATUS_SUCCESS;
}

Error cairoError(cairo_status_t status, std::string where) {
    const bool memory = status == CAIRO_STATUS_NO_MEMORY;
    return {memory ? ErrorCode::resourceExhausted : ErrorCode::internal, std::move(where),
            cairo_status_to_string(status)};
}

CairoSurface surfaceOf(const ImageMark& image) {
    CairoSurface surface(cairo_image_surface_create(CAIRO_FORMAT_ARGB32, static_cast<int>(image.width),
                                                    static_cast<int>(image.height)));
    auto* row = cairo_image_surface_get_data(surface.get());
    if (row == nullptr) return surface;  // whoever draws it is told why
    const auto stride = cairo_image_surface_get_stride(surface.get());
    const std::uint8_t* from = image.rgba.data();
    const auto times = [](std::uint32_t value, std::uint32_t share) { return (value * share + 127) / 255; };
    for (std::uint32_t y = 0; y < image.height; ++y, row += stride) {
        for (std::uint32_t x = 0; x < image.width; ++x, from += 4) {
            const std::uint32_t a = from[3];
            const std::uint32_t pixel =
                (a << 24) | (times(from[0], a) << 16) | (times(from[1], a) << 8) | times(from[2], a);
            std::memcpy(row + 4 * std::size_t{x}, &pixel, 4);
        }
    }
    cairo_surface_mark_dirty(surface.get());
    return surface;
}

Result<DocumentBytes> pngOf(cairo_surface_t* surface) {
    DocumentBytes bytes;
    const auto status = cairo_surface_write_to_png_stream(surface, appendBytes, &bytes);
    if (status != CAIRO_STATUS_SUCCESS) return cairoError(status, "picture");
    return bytes;
}

void removePdfDate(DocumentBytes& bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const auto at = text.rfind("/CreationDate (");
    if (at == std::string_view::npos) return;
    const auto end = text.find(')', at);
    if (end == std::string_view::npos) return;
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(at),
              bytes.begin() + static_cast<std::ptrdiff_t>(end + 1), ' ');
}

}  // namespace mote::server
