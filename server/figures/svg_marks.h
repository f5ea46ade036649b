// SPDX-License-Identifier: GPL-3.0-or-later
//
// Writes marks as elements of SVG. Text becomes outlines, so that it looks alike wherever it is opened, with
// its words beside them for whoever cannot see. Pure functions; the same marks give the same bytes. (Cairo's
// own SVG numbers its parts anew in each drawing.)
#pragma once

#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "server/figures/marks.h"
#include "server/figures/typeface.h"

namespace mote::server {

/// Errors: resourceExhausted (memory), of images.
Result<std::string> svgOf(const Marks& marks, const Typeface& typeface);

/// Text as an attribute or as content: without what XML would obey or forbids.
std::string escapedXml(std::string_view text);

/// RFC 4648, section 4.
std::string base64(const std::vector<std::uint8_t>& bytes);

/// A number with at most so many decimals, without zeros that say nothing.
std::string shortNumber(double value, int decimals = 3);

/// "#rrggbb" of an sRGB-encoded colour.
std::string hexColor(const glm::vec3& color);

}  // namespace mote::server
