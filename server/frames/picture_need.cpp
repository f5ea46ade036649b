// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a picture takes in memory at most, told before any of it is taken. The numbers are held to by
// tests/reliability/peak_memory.py, which draws every kind and looks.
#include <algorithm>
#include <cmath>

#include "protocol/scene/fields/facts.h"
#include "server/encode/encode.h"
#include "server/frames/planning.h"
#include "server/render/layers/contrast/lower_contrast.h"
#include "server/render/layers/ink/mesh_lines.h"
#include "server/render/layers/stipple/tone.h"

namespace mote::server {
namespace {

/// Bytes a pixel: while its layer becomes primitives, and until the picture is done.
struct PixelNeed {
    double planned = 0.0, kept = 0.0;
};

/// Dots as they are made, in the scene, as the device takes them, and in lists of tiles.
constexpr double bytesOfADot = 48.0 + 48.0 + 48.0 + 8.0;

/// How many there are at most.
double dotsOf(const StippleStyle& style, const proto::Manifest* manifest, double pixels) {
    const double spaced = render::densityOfSpacing(lengthOf(style, style.kSpacingPixelsFieldNumber)) * pixels;
    if (onPlane(style) || manifest == nullptr) return spaced;
    return std::min(spaced, static_cast<double>(manifest->stipple().points()));
}

/// Whether anything of it is washed, everywhere or where it is painted.
bool washes(const proto::InkStyle& ink) {
    return ink.has_wash() || std::any_of(ink.regions().begin(), ink.regions().end(),
                                         [](const auto& region) { return region.fill() == "wash"; });
}

/// Of the layer's kind; dots apart.
PixelNeed needOf(const Layer& layer, const proto::Manifest* manifest, double pixels) {
    if (const auto* const ink = layer.ink()) {
        constexpr double ofPicture = 44.0;      // that is shown in place of strokes
        constexpr double ofWash = 8.0;          // kept: its pigment, and at which depth it lies
        constexpr double whileWashed = 72.0;    // with what distances to its edges take
        constexpr double mostFine = 1U << 23U;  // as of volume_modalities: four rays in some pixels
        const bool mesh = manifest != nullptr && manifest->has_mesh();
        const bool washed = washes(*ink);
        double planned = !mesh && pixels <= mostFine ? 84.0 : 52.0;
        if (washed) planned = std::max(planned, whileWashed);
        if (mesh && ink->silhouettes().suggestive())
            planned += render::suggestiveBytes * static_cast<double>(manifest->mesh().triangles()) / pixels;
        return {planned, ink->show().empty() ? 6.0 + (washed ? ofWash : 0.0) : ofPicture};
    }
    // Fragments, in a list, and as a device takes them.
    if (layer.hybrid() != nullptr && !layer.hybrid()->shows().empty()) return {32.0, 32.0 + 40.0};
    PixelNeed need;
    if (layer.stipple() != nullptr && !layer.stipple()->source().empty()) need.planned = 28.0;
    if (layer.particles() != nullptr) need.kept = layer.highlight ? 16.0 : 0.0;
    if (layer.particles() != nullptr && layer.colorBy) {
        need.planned = 24.0;
        need.kept += 6.0;
    }
    return need;
}

}  // namespace

std::uint64_t encodingBytes(const render::Picture& picture, bool annotated, bool page) {
    const bool half = picture.format == render::PixelFormat::linearHalf;
    // What more a picture of noise would be is counted when it is there (PictureMemory::Taken::become).
    const double filtered = half ? 5.0 : 3.0;
    const double overlay = annotated ? 4.0 : 0.0;
    return picture.pixels.capacity() +
           static_cast<std::uint64_t>((std::max(overlay, filtered) + (page ? 16.0 : 0.0)) * picture.width *
                                      picture.height);
}

std::uint64_t pictureBytes(const View& view, const RenderJob& job, StepSource& data) {
    const bool page = job.task->page.has_value();
    const bool half = job.part.has_value() ||
                      (job.stage == Stage::exact && job.task->format == render::PixelFormat::linearHalf);
    const double pixels = static_cast<double>(view.width) * view.height;
    const double own = half ? 8.0 : 4.0, encoded = half ? 5.0 : view.annotations ? 4.0 : 3.0;
    PixelNeed all;
    double dots = 0.0;
    bool points = false;
    for (const Layer& layer : view.layers) {
        if (!(layer.opacity > 0.0)) continue;
        const auto entry = data.dataset(layer.dataset);
        const auto* const manifest = entry.ok() ? entry->manifest.get() : nullptr;
        const auto need = needOf(layer, manifest, pixels);
        all.planned = std::max(all.planned, need.planned);
        all.kept += need.kept;
        points = points || layer.particles() != nullptr;
        if (layer.stipple() != nullptr) dots += dotsOf(*layer.stipple(), manifest, pixels);
    }
    if (render::contrastsDepth(view)) {
        all.planned =
            std::max(all.planned, render::orderBytes + render::contrastLayerBytes * view.layers.size());
        all.kept += render::contrastBytes;
    }
    // Counts of points, where there is nothing else; black and white pictures that tell what is seen of
    // shapes.
    all.planned = std::max({all.planned, points ? 4.0 : 0.0, page ? 24.0 : 0.0});
    const double drawn = std::max(all.planned + all.kept, all.kept + own + (points ? 4.0 : 0.0));
    const double most = std::max(drawn, own + encoded + (page ? 16.0 : 0.0));
    return static_cast<std::uint64_t>(most * pixels + dots * bytesOfADot);
}

}  // namespace mote::server
