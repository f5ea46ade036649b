// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/image/upright.h"

#include <utility>

namespace mote::prep {

storage::Luminance upright(storage::Luminance picture, int orientation) {
    if (orientation < 2 || orientation > 8) return picture;
    // Exif 2.3, table of orientations: which sides of the stored picture are the top and the left one.
    const bool transposed = orientation >= 5;
    const bool fromRight = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
    const bool fromBottom = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
    storage::Luminance turned{picture.width, picture.height, std::vector<float>(picture.values.size())};
    if (transposed) std::swap(turned.width, turned.height);
    for (std::size_t y = 0; y < turned.height; ++y) {
        for (std::size_t x = 0; x < turned.width; ++x) {
            const std::size_t alongX = transposed ? y : x;
            const std::size_t alongY = transposed ? x : y;
            turned.values[y * turned.width + x] =
                picture.at(fromRight ? picture.width - 1 - alongX : alongX,
                           fromBottom ? picture.height - 1 - alongY : alongY);
        }
    }
    return turned;
}

}  // namespace mote::prep
