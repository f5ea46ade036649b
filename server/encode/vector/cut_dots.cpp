// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/encode/vector/cut_dots.h"

#include <algorithm>
#include <glm/common.hpp>

#include "server/encode/vector/clip_path.h"
#include "server/encode/vector/paint.h"

namespace mote::server {
namespace {

constexpr float alikeWithin = 0.06F;  // of encoded colours: 15 of 255
constexpr float littleInk = 0.05F;    // of a pixel: its colour is not looked at
constexpr float halfThrough = 0.5F;

struct CoveredPixel {
    std::uint32_t column, row;
    float covers;
    InFront inFront;
    glm::vec3 seen;  // linear RGB
};

float difference(const glm::vec3& a, const glm::vec3& b) {
    const auto apart = glm::abs(encoded(a) - encoded(b));
    return std::max({apart.x, apart.y, apart.z});
}

/// What is seen of it, all in all.
struct Mean {
    InFront inFront{glm::vec3(0.0F), 0.0F};
    glm::vec3 seen{0.0F};
};

Mean meanOf(const std::vector<CoveredPixel>& pixels) {
    Mean mean;
    float sum = 0.0F;
    for (const auto& pixel : pixels) {
        mean.inFront.light += pixel.covers * pixel.inFront.light;
        mean.inFront.through += pixel.covers * pixel.inFront.through;
        mean.seen += pixel.covers * pixel.seen;
        sum += pixel.covers;
    }
    mean.inFront.light /= sum;
    mean.inFront.through /= sum;
    mean.seen /= sum;
    return mean;
}

/// Runs of pixels of a row that are alike, but for those in which it is hidden.
std::vector<SeenDot> piecesOf(const render::Dot& dot, const std::vector<CoveredPixel>& pixels) {
    std::vector<SeenDot> pieces;
    const auto disc = discPath(dot.radius);
    const glm::dvec2 centre(dot.x, dot.y);
    for (std::size_t begin = 0; begin < pixels.size();) {
        const auto& first = pixels[begin];
        std::size_t end = begin + 1;
        const auto goesOn = [&](const CoveredPixel& next) {
            return next.row == first.row && next.column == first.column + (end - begin) &&
                   next.inFront.hidden() == first.inFront.hidden() &&
                   difference(next.seen, first.seen) <= alikeWithin;
        };
        while (end < pixels.size() && goesOn(pixels[end])) ++end;
        const glm::dvec2 low(first.column, first.row);
        const ClipBox box{low - centre, low + glm::dvec2(end - begin, 1.0) - centre};
        if (!first.inFront.hidden()) {
            const auto mean = meanOf({pixels.begin() + static_cast<std::ptrdiff_t>(begin),
                                      pixels.begin() + static_cast<std::ptrdiff_t>(end)});
            if (auto outline = clipped(disc, box); !outline.empty())
                pieces.push_back({mean.seen, std::move(outline)});
        }
        begin = end;
    }
    return pieces;
}

}  // namespace

std::vector<SeenDot> seenOf(const render::Dot& dot, const Sight& sight, const PictureSize& size,
                            bool plotter) {
    std::vector<CoveredPixel> pixels;
    bool allClear = true, allHidden = true;
    forCovered(dot, size, [&](std::uint32_t column, std::uint32_t row, float covers) {
        const auto inFront = sight.at(column, row, dot.depth);
        allClear = allClear && inFront.clear();
        allHidden = allHidden && inFront.hidden();
        pixels.push_back({column, row, covers, inFront, inFront.seen(dot.color)});
    });
    if (allClear) return {{dot.color, {}}};  // also out of the picture
    if (allHidden) return {};
    const Mean mean = meanOf(pixels);
    if (plotter) {
        if (mean.inFront.through < halfThrough) return {};
        return {{dot.color, {}}};
    }
    const bool even = std::all_of(pixels.begin(), pixels.end(), [&](const CoveredPixel& pixel) {
        return pixel.covers < littleInk || difference(pixel.seen, mean.seen) <= alikeWithin;
    });
    if (even) return {{mean.seen, {}}};
    return piecesOf(dot, pixels);
}

}  // namespace mote::server
