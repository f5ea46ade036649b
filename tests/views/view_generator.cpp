// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/views/view_generator.h"

#include <array>
#include <utility>

#include "protocol/scene/view.h"
#include "tests/views/number_data.h"
#include "tests/views/random_camera.h"
#include "tests/views/random_curves.h"
#include "tests/views/random_places.h"
#include "tests/views/random_styles.h"

namespace mote::test {
namespace {

/// Width and height of a picture; the last ones are for those who have time.
std::pair<std::uint32_t, std::uint32_t> anySize(Random& random, std::uint64_t mostPixels) {
    static constexpr std::array<std::pair<std::uint32_t, std::uint32_t>, 14> sizes{{{1, 1},
                                                                                    {1, 37},
                                                                                    {61, 1},
                                                                                    {16, 9},
                                                                                    {17, 5},
                                                                                    {24, 16},
                                                                                    {32, 24},
                                                                                    {31, 17},
                                                                                    {33, 23},
                                                                                    {4, 150},
                                                                                    {64, 48},
                                                                                    {97, 61},
                                                                                    {160, 100},
                                                                                    {4096, 16}}};
    while (true) {
        const auto size = sizes[random.below(sizes.size())];
        const bool odd = size.first == 1 || size.second == 1;
        if (odd && random.chance(0.7)) continue;
        if (std::uint64_t{size.first} * size.second <= mostPixels) return size;
    }
}

DataKind anyKind(Random& random) {
    const double kind = random.unit();
    if (kind < 0.5) return DataKind::particles;
    if (kind < 0.8) return DataKind::hybrid;
    return kind < 0.9 ? DataKind::dots : DataKind::mesh;
}

std::uint64_t layerCount(Random& random) {
    if (random.chance(0.45)) return 1;
    if (random.chance(0.02)) return 0;
    return random.chance(0.6) ? 2 + random.below(2) : 1 + random.below(8);
}

/// Some layers of volumes and particles are drawings instead. By numbers of their own: all else stays as it
/// would be.
void drawInInk(const DatasetName& data, proto::Layer& layer) {
    constexpr double share = 0.1;
    if (data.kind != DataKind::hybrid && data.kind != DataKind::particles) return;
    Random random(layer.ByteSizeLong(), data.number);
    if (random.chance(share)) *layer.mutable_ink() = anyInkStyle(random, ViewData::traits(data));
}

/// Some layers come or go, in films. By numbers of their own, too.
void fade(const DatasetName& data, proto::Layer& layer) {
    constexpr double share = 0.3, nothing = 0.15;
    Random random(layer.ByteSizeLong(), 64 + data.number);
    if (!random.chance(share)) return;
    const double some = anyShare(random);
    layer.set_opacity(random.chance(nothing) ? 0.0 : some);
}

/// Some layers of particles show their numbers. By numbers of their own, too.
void showNumbers(const DatasetName& data, proto::Layer& layer) {
    constexpr double share = 0.35;
    Random random(layer.ByteSizeLong(), 128 + data.number);
    if (layer.has_particles() && random.chance(share)) setAnyNumbers(random, ViewData::steps, layer);
}

/// Some layers are on their way to another step, in films. By numbers of their own, too.
void goOn(const DatasetName& data, proto::Layer& layer) {
    constexpr double share = 0.15;
    if (!layer.has_particles() && !layer.has_hybrid()) return;
    Random random(layer.ByteSizeLong(), 256 + data.number);
    if (!random.chance(share)) return;
    layer.mutable_towards()->set_step(static_cast<std::uint32_t>(random.below(ViewData::steps)));
    layer.mutable_towards()->set_share(anyShare(random));
}

/// Of some layers something is cut away, which lie in `bounds`. By numbers of their own, too.
void cut(const Bounds& bounds, std::uint64_t number, proto::Layer& layer) {
    constexpr double share = 0.3;
    Random random(layer.ByteSizeLong(), 512 + number);
    if (!random.chance(share)) return;
    auto clip = anyClip(random, bounds);
    const auto& own = layer.hybrid();
    if (own.has_clip_box()) clip.clear_box();
    if (own.clip_planes_size() + clip.planes_size() > mostClipPlanes) clip.clear_planes();
    if (random.chance(0.5)) {
        *layer.mutable_clip() = clip;
        return;
    }
    *layer.mutable_clip_planes() = clip.planes();
    if (clip.has_box()) *layer.mutable_clip_box() = clip.box();
}

/// A layer of any dataset, without its transform.
proto::Layer anyLayer(Random& random, const DatasetName& data) {
    proto::Layer layer;
    layer.set_dataset(data.toString());
    layer.set_step(static_cast<std::uint32_t>(random.below(ViewData::steps)));
    if (data.kind == DataKind::particles) *layer.mutable_particles() = anyParticlesStyle(random);
    if (data.kind == DataKind::hybrid)
        *layer.mutable_hybrid() = anyHybridStyle(random, ViewData::traits(data));
    if (data.kind == DataKind::dots) *layer.mutable_stipple() = anyStippleStyle(random);
    if (data.kind == DataKind::mesh && random.chance(0.5))
        *layer.mutable_ink() = anyInkStyle(random);
    else if (data.kind == DataKind::mesh)
        *layer.mutable_mesh() = anyMeshStyle(random);
    drawInInk(data, layer);
    fade(data, layer);
    showNumbers(data, layer);
    goOn(data, layer);
    cut(ViewData::traits(data).bounds, data.number, layer);
    return layer;
}

/// A negative zero, which does not come back from a file, is none.
double positiveZero(double value) {
    return value + 0.0;
}

void setTransform(const glm::dmat4& transform, proto::Layer& layer) {
    if (transform == glm::dmat4(1.0)) return;
    for (int i = 0; i < 16; ++i) layer.add_transform(positiveZero(transform[i % 4][i / 4]));
}

void setCamera(const Camera& camera, proto::View& view) {
    auto& message = *view.mutable_camera();
    message = toProto(camera);
    for (auto* const vector : {message.mutable_eye(), message.mutable_target(), message.mutable_up()})
        for (double& value : *vector) value = positiveZero(value);
}

/// What the camera is aimed at: one layer, or all of them.
Bounds aimOf(Random& random, const std::vector<Bounds>& inWorld) {
    if (inWorld.empty()) return plotBounds;
    Bounds all = inWorld[random.below(inWorld.size())];
    if (random.chance(0.3)) {
        for (const auto& bounds : inWorld) all = all.united(bounds);
    }
    return all;
}

/// Some views have images behind all else, at any place among the layers. By numbers of their own, too.
void addImages(proto::View& view) {
    constexpr double share = 0.12, another = 0.3;
    Random random(view.ByteSizeLong(), 1024);
    for (bool more = random.chance(share); more && view.layers_size() < View::maxLayers;
         more = random.chance(another)) {
        auto& layer = *view.add_layers();
        layer.set_dataset(ViewData::any(random, DataKind::image).toString());
        layer.mutable_image();
        if (random.chance(0.5)) layer.set_opacity(anyShare(random));
        cut(plotBounds, 0, layer);
        const auto last = view.layers_size() - 1;
        view.mutable_layers()->SwapElements(
            last, static_cast<int>(random.below(static_cast<std::uint64_t>(last) + 1)));
    }
}

/// Layers of some views are hidden or have a name. By numbers of their own, at last: all else stays as it
/// would be.
void nameAndHide(proto::View& view) {
    constexpr double some = 0.15, hidden = 0.4, named = 0.5;
    Random random(view.ByteSizeLong(), 2048);
    if (!random.chance(some)) return;
    for (auto& layer : *view.mutable_layers()) {
        layer.set_hidden(random.chance(hidden));
        if (random.chance(named)) layer.set_name(random.oneOf({"core", "halo", "\u00e4u\u00dferer \u2207"}));
    }
}

/// Some views tell more plainly what is nearer. By numbers of their own, too.
void contrastDepth(proto::View& view) {
    constexpr double share = 0.2, all = 0.3;
    Random random(view.ByteSizeLong(), 4096);
    if (!random.chance(share)) return;
    const double some = anyShare(random);
    view.set_depth_contrast(random.chance(all) ? 1.0 : some);
}

proto::View tryView(Random& random, const ViewShape& shape) {
    proto::View view;
    const auto [width, height] = anySize(random, shape.mostPixels);
    view.set_width(width);
    view.set_height(height);
    if (random.chance(0.5)) setAnyColor(random, view.mutable_background());
    std::vector<Bounds> inLayer, inWorld;
    for (auto count = layerCount(random); count > 0; --count) {
        const DataKind kind = anyKind(random);
        const auto data = ViewData::any(random, kind);
        *view.add_layers() = anyLayer(random, data);
        inLayer.push_back(ViewData::traits(data).bounds);
    }
    const auto transforms = anyTransforms(random, inLayer);
    for (std::size_t i = 0; i < transforms.size(); ++i) {
        setTransform(transforms[i], *view.mutable_layers(static_cast<int>(i)));
        inWorld.push_back(inLayer[i].transformed(transforms[i]));
    }
    const Bounds aim = aimOf(random, inWorld);
    const Camera camera = anyCamera(random, aim);
    const bool fitted = random.chance(0.1);
    if (!fitted) setCamera(camera, view);
    if (!fitted && random.chance(0.1)) view.mutable_camera()->clear_fov_y_degrees();
    addImages(view);
    nameAndHide(view);
    contrastDepth(view);
    return view;
}

}  // namespace

proto::View generatedView(std::uint64_t seed, std::uint64_t number, const ViewShape& shape) {
    Random random(seed, number);
    while (true) {
        // Where eye and target coincide in their digits, or a box has no room left, the next one is taken.
        auto view = tryView(random, shape);
        if (parseView(view).ok()) return view;
    }
}

}  // namespace mote::test
