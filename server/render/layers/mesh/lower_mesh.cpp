// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/mesh/mesh_sight.h"

#include <array>
#include <new>
#include <utility>

#include "server/render/layers/pixel_fragments.h"

namespace mote::render {
namespace {

/// Fragments of a tile, and meetings of a pixel, at most: 256 and 48 MB.
constexpr std::size_t mostFragments = std::size_t{1} << 23, mostMeetings = std::size_t{1} << 20;

/// Makes the fragments of some pixels, one thread's.
class PixelLooks {
  public:
    /// `firstOnly`: nothing is seen behind what a ray meets first.
    PixelLooks(const MeshSight& sight, const MeshRays& rays, bool firstOnly, const PixelFragments& pixel,
               Fragments& fragments)
        : sight_(sight),
          mesh_(rays),
          firstOnly_(firstOnly),
          samples_(pixel.samples()),
          pixels_(MeshRays::packet / samples_, pixel),
          fragments_(fragments) {}

    void look(std::uint32_t row, std::uint32_t from, std::uint32_t to) {
        const auto step = static_cast<std::uint32_t>(pixels_.size());
        for (std::uint32_t column = from; column < to; column += step)
            drawPacket(column, std::min(to - column, step), row);
    }

  private:
    /// `count` pixels from a column on.
    void drawPacket(std::uint32_t column, std::uint32_t count, std::uint32_t row) {
        bool any = false;
        for (std::uint32_t i = 0; i < MeshRays::packet; ++i) {
            inLayer_[i] = {};
            if (i >= count * samples_) continue;
            const auto [x, y] = samples_ == 1 ? std::array{0, 0} : PixelFragments::places[i % samples_];
            const std::uint32_t pixel = column + i / samples_;
            rays_[i] = sight_.through(pixel + 0.5 + x / 16.0, row + 0.5 + y / 16.0);
            inLayer_[i] = rays_[i].inLayer;
            any = any || !inLayer_[i].empty();
        }
        if (!any) return;
        firstOnly_ ? meetFirst() : meetAll();
        for (std::uint32_t i = 0; i < count; ++i) pixels_[i].take(column + i, row, fragments_);
    }
    void meetFirst() {
        std::array<MeshMeeting, MeshRays::packet> met;
        mesh_.first(inLayer_, met);
        for (std::uint32_t i = 0; i < MeshRays::packet; ++i) {
            if (met[i].triangle != MeshMeeting::none) add(i, met[i]);
        }
    }
    void meetAll() {
        for (std::uint32_t i = 0; i < MeshRays::packet; ++i) {
            mesh_.all(inLayer_[i], met_);
            if (met_.size() > mostMeetings) throw std::bad_alloc();
            for (const auto& met : met_) add(i, met);
        }
    }
    void add(std::uint32_t index, const MeshMeeting& met) {
        if (const auto hit = sight_.hit(rays_[index], met))
            pixels_[index / samples_].add({hit->depth, index % samples_, hit->color});
    }

    const MeshSight& sight_;
    const MeshRays& mesh_;
    const bool firstOnly_;
    const std::uint32_t samples_;
    std::vector<PixelFragments> pixels_;           // of a packet
    std::array<SightRay, MeshRays::packet> rays_;  // of its samples, pixel by pixel
    std::array<MeshRay, MeshRays::packet> inLayer_;
    std::vector<MeshMeeting> met_;
    Fragments& fragments_;
};

/// A layer's, as it is looked at.
class SurfaceFragments : public FragmentMaker {
  public:
    SurfaceFragments(std::shared_ptr<const MeshSurface> surface, const MeshSight& sight,
                     const PixelFragments& pixel, bool firstOnly)
        : surface_(std::move(surface)),
          sight_(sight),
          touched_(sight.touched()),
          pixel_(pixel),
          firstOnly_(firstOnly) {}

    void make(const PixelRect& pixels, Fragments& fragments) const override {
        const PixelRect seen{std::max(pixels.left, touched_.left), std::max(pixels.top, touched_.top),
                             std::min(pixels.right, touched_.right),
                             std::min(pixels.bottom, touched_.bottom)};
        if (seen.empty()) return;
        PixelLooks looks(sight_, surface_->rays(), firstOnly_, pixel_, fragments);
        const std::size_t before = fragments.size();
        for (auto row = seen.top; row < seen.bottom; ++row) {
            looks.look(row, seen.left, seen.right);
            if (fragments.size() - before > mostFragments) throw std::bad_alloc();
        }
    }

  private:
    std::shared_ptr<const MeshSurface> surface_;
    MeshSight sight_;
    PixelRect touched_;
    PixelFragments pixel_;
    bool firstOnly_;
};

}  // namespace

void lowerMesh(const Layer& layer, const MeshStyle& style, std::shared_ptr<const MeshSurface> surface,
               Lowering& out) {
    const FramePlan& plan = out.plan;
    const MeshSight sight(plan, layer.transform, style, *surface, out.pixels, layer.clips());
    const double opacity = style.opacity() * layer.opacity;
    if (!(opacity > 0.0) || sight.touched().empty()) return;
    const PixelFragments pixel(plan.exact ? PixelFragments::mostSamples : 1, opacity,
                               (sight.farDepth() - sight.nearDepth()) / out.slabs);
    const bool firstOnly = !style.wire() && opacity == 1.0;
    out.addDots(sight.nearDepth(), sight.farDepth());
    out.plan.surfaces.push_back(
        std::make_shared<const SurfaceFragments>(std::move(surface), sight, pixel, firstOnly));
}

}  // namespace mote::render
