// SPDX-License-Identifier: GPL-3.0-or-later
//
// Cairo's surfaces and contexts as values that clean up after themselves, and its streams as bytes. For the
// sources that draw by Cairo alone; one thread each.
#pragma once

#include <cairo.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "protocol/base/error.h"
#include "server/figures/marks.h"

namespace mote::server {

struct DestroyCairo {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* context) const { cairo_destroy(context); }
};
using CairoSurface = std::unique_ptr<cairo_surface_t, DestroyCairo>;
using CairoContext = std::unique_ptr<cairo_t, DestroyCairo>;
using DocumentBytes = std::vector<std::uint8_t>;

/// A cairo_write_func_t whose closure is DocumentBytes.
cairo_status_t appendBytes(void* bytes, const unsigned char* data, unsigned int size);

/// `where`: the error's.
Error cairoError(cairo_status_t status, std::string where);

/// An image surface of the pixels of a mark.
CairoSurface surfaceOf(const ImageMark& image);

/// A PNG file. Errors: resourceExhausted (memory), internal.
Result<DocumentBytes> pngOf(cairo_surface_t* surface);

/// The same drawing is to give the same bytes: in a finished PDF the date becomes spaces, as many as there
/// were bytes, which its table of offsets wants.
void removePdfDate(DocumentBytes& bytes);

}  // namespace mote::server
