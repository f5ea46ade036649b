// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/contrast/lower_contrast.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <optional>
#include <utility>

#include "protocol/scene/length_scale.h"
#include "protocol/scene/srgb.h"
#include "server/render/layers/ink/volume_rays.h"
#include "server/render/layers/make_frame_plan.h"
#include "server/render/plan/in_turns.h"
#include "server/render/plan/work_in_turns.h"

namespace mote::render {
namespace {

constexpr double mostBlock = 4.0;  // pixels a side, of one of 720 lines at least: one ray may stand for all
constexpr double otherOpacity = 0.2;  // of a ray, and depth by the extent: rays that differ by more see
constexpr double otherDepth = 0.02;   // something else
constexpr double leastLost = 0.1;     // of a pixel's light, where anything is seen
constexpr double beginsAt = 0.05;     // of what a layer takes: there it begins
constexpr double leastSeen = 0.02;    // of a ray that sees something

/// CIE L*, 0 to 1, of linear light.
float lightness(double luminance) {
    const double y = std::clamp(luminance, 0.0, 1.0);
    return static_cast<float>(y > 216.0 / 24389.0 ? 1.16 * std::cbrt(y) - 0.16 : y * 243.89 / 27.0);
}

/// A surface by one ray a pixel: where it is first met, how much it hides and how light it is.
struct SeenSurface {
    Raster<float> depth;                 ///< infinity where it is not met
    Raster<std::uint8_t> opacity, tone;  ///< 255ths
};

/// A volume by rays.
struct SeenVolume {
    std::shared_ptr<const GridField> field;
    std::shared_ptr<const StepVolume> cells;  ///< of particles; null: of a hybrid volume
    TransferFunction transfer;
    std::unique_ptr<VolumeRays> rays;
};

/// One that takes part.
struct Participant {
    std::optional<SeenSurface> surface;
    std::optional<SeenVolume> volume;
};

/// The picture in one ray a pixel.
FramePlan quickPlan(const FramePlan& plan) {
    return {.width = plan.width,
            .height = plan.height,
            .camera = plan.camera,
            .background = plan.background,
            .exact = false};
}

/// The cells of a step as a field of codes: the root of its extinction, which a curve cubes again.
SeenVolume volumeOfCells(const FieldPlan& plan, const DensityField& density) {
    constexpr int knots = 64;
    const auto& cells = *density.grid;
    const double most = static_cast<double>(*std::max_element(cells.root.begin(), cells.root.end()));
    auto field = std::make_shared<GridField>();
    field->boxToLayer = plotToLayer() * cells.toPlot();
    field->coarse.size = cells.size;
    field->coarse.values.resize(cells.root.size() + 4);
    field->coarse.normals.resize(cells.root.size() + 4);
    for (std::size_t i = 0; i < cells.root.size() && most > 0.0; ++i)
        field->coarse.values[i] =
            static_cast<std::uint16_t>(std::lround(65535.0 * static_cast<double>(cells.root[i]) / most));
    std::vector<Curve::Knot> curve;
    for (int i = 0; i <= knots; ++i) {
        const double x = static_cast<double>(i) / knots;
        curve.push_back({x, -std::expm1(-x * x * x)});
    }
    const double extinction = most * most * most * density.strength;
    return {field, density.grid,
            TransferFunction{.opacity = Curve::create(std::move(curve)).value(),
                             .opacityLength = 1.0 / std::max(extinction, 1e-300),
                             .colorMap = plan.transfer.colorMap,
                             .colorRange = plan.transfer.colorRange,
                             .colors = {}},
            nullptr};
}

Light matterLight(const Layer& layer) {
    if (layer.hybrid() != nullptr) return hybridStyleOf(*layer.hybrid()).light;
    Light even;
    even.ambient = 1.0;
    even.diffuse = 0.0;
    return even;
}

/// A field of the plan, seen from its camera.
SeenVolume seenVolume(const Layer& layer, const FieldPlan& plan, const FramePlan& quick) {
    const auto* const density = plan.density();
    auto seen = density != nullptr ? volumeOfCells(plan, *density)
                                   : SeenVolume{plan.grid()->grid, nullptr, plan.transfer, nullptr};
    seen.rays = std::make_unique<VolumeRays>(InkVolume{seen.field, seen.transfer, layer.clips()},
                                             layer.transform, matterLight(layer), quick);
    seen.rays->findSpans();
    return seen;
}

SeenSurface seenSurface(const FragmentMaker& maker, const FramePlan& quick, const std::stop_token& stop) {
    SeenSurface seen{Raster<float>(quick.width, quick.height, HUGE_VALF),
                     Raster<std::uint8_t>(quick.width, quick.height),
                     Raster<std::uint8_t>(quick.width, quick.height)};
    forPixelsInTurns(quick.width, quick.height, [&](std::uint32_t row, std::uint32_t from, std::uint32_t to) {
        if (isStopped(stop)) return;
        Fragments fragments;
        maker.make({from, row, to, row + 1}, fragments);
        for (const auto& fragment : fragments) {
            float& depth = seen.depth.at(fragment.column, row);
            if (!(static_cast<float>(fragment.depth) < depth)) continue;
            depth = static_cast<float>(fragment.depth);
            const float tone = lightness(luminance(glm::dvec3(fragment.color)));
            seen.opacity.at(fragment.column, row) =
                static_cast<std::uint8_t>(std::lround(255.0F * fragment.opacity));
            seen.tone.at(fragment.column, row) = static_cast<std::uint8_t>(std::lround(255.0F * tone));
        }
    });
    return seen;
}

/// What a layer's surface is in one ray a pixel, whatever its kind; null where it shows none.
std::shared_ptr<const FragmentMaker> surfaceMaker(Scene scene, std::size_t index, const FramePlan& plan,
                                                  const std::stop_token& stop) {
    scene.view.width = plan.width;
    scene.view.height = plan.height;
    scene.view.depthContrast = 0.0;
    scene.dots = nullptr;
    for (std::size_t i = 0; i < scene.view.layers.size(); ++i) {
        if (i != index) scene.view.layers[i].opacity = 0.0;
    }
    SelectionCache selections;
    const auto alone = makeFramePlan(scene, {.slabs = 1}, selections, {}, Reading::notForPoints, stop);
    return alone.surfaces.empty() ? nullptr : alone.surfaces.front();
}

bool showsSurface(const Layer& layer) {
    return layer.mesh() != nullptr || (layer.hybrid() != nullptr && !layer.hybrid()->shows().empty());
}

/// All that take part, in the order of their layers.
std::vector<Participant> participantsOf(const Scene& scene, const FramePlan& plan,
                                        const std::stop_token& stop) {
    const FramePlan quick = quickPlan(plan);
    std::vector<Participant> made;
    for (std::size_t i = 0; i < scene.view.layers.size() && !isStopped(stop); ++i) {
        const Layer& layer = scene.view.layers[i];
        if (!hasDepth(layer)) continue;
        if (showsSurface(layer)) {
            if (const auto maker = surfaceMaker(scene, i, plan, stop))
                made.push_back({seenSurface(*maker, quick, stop), std::nullopt});
            continue;
        }
        const auto field = std::find_if(plan.fields.begin(), plan.fields.end(),
                                        [i](const FieldPlan& one) { return one.layer == i; });
        if (field == plan.fields.end() || (field->density() && field->density()->grid->empty())) continue;
        auto volume = seenVolume(layer, *field, quick);
        if (volume.rays->any()) made.push_back({std::nullopt, std::move(volume)});
    }
    return made;
}

/// A picture in squares of pixels.
struct Blocks {
    std::uint32_t side, width, height;  ///< of one, pixels; of all, blocks

    Blocks(const FramePlan& plan, double pixels)
        : side(static_cast<std::uint32_t>(std::clamp(std::round(mostBlock * pixels), 1.0, mostBlock))),
          width((plan.width + side - 1) / side),
          height((plan.height + side - 1) / side) {}

    /// Its pixels, of a picture of a plan's size.
    PixelRect pixels(std::uint32_t x, std::uint32_t y, const FramePlan& plan) const {
        return {x * side, y * side, std::min(plan.width, (x + 1) * side),
                std::min(plan.height, (y + 1) * side)};
    }
};

/// take(i, j) for a block and those around it.
template <class Take>
void eachAround(const Blocks& blocks, std::uint32_t x, std::uint32_t y, const Take& take) {
    for (auto j = y > 0 ? y - 1 : 0; j <= std::min(y + 1, blocks.height - 1); ++j) {
        for (auto i = x > 0 ? x - 1 : 0; i <= std::min(x + 1, blocks.width - 1); ++i) take(i, j);
    }
}

/// Blocks in which several of those that take part may be seen, or so many pixels away.
Raster<std::uint8_t> sharedBlocks(const std::vector<Participant>& all, const Blocks& blocks, double reach) {
    Raster<std::uint8_t> seen(blocks.width, blocks.height);  // a bit each
    for (std::size_t i = 0; i < all.size(); ++i) {
        const auto bit = static_cast<std::uint8_t>(1U << i);
        if (!all[i].surface) {
            for (auto& block : seen.values) block |= bit;
            continue;
        }
        const auto& depth = all[i].surface->depth;
        for (std::uint32_t y = 0; y < depth.height; ++y) {
            for (std::uint32_t x = 0; x < depth.width; ++x) {
                if (std::isfinite(depth.at(x, y))) seen.at(x / blocks.side, y / blocks.side) |= bit;
            }
        }
    }
    for (auto passes = static_cast<std::uint32_t>(std::ceil(reach / blocks.side)); passes > 0; --passes) {
        const auto before = seen.copy();
        for (std::uint32_t y = 0; y < blocks.height; ++y) {
            for (std::uint32_t x = 0; x < blocks.width; ++x)
                eachAround(blocks, x, y, [&](auto i, auto j) { seen.at(x, y) |= before.at(i, j); });
        }
    }
    for (auto& block : seen.values) block = (block & (block - 1U)) != 0 ? 1 : 0;
    return seen;
}

/// Looks into pixels, one thread's, and tells what is nearest.
class PixelLook {
  public:
    PixelLook(const std::vector<Participant>& all, DepthOrder& order)
        : all_(all), order_(order), scratch_(all.size()), rays_(all.size()), taken_(all.size()) {}

    /// Sends the rays through a pixel's middle that tell what volumes are there, and around.
    void aim(std::uint32_t column, std::uint32_t row) {
        for (std::size_t i = 0; i < all_.size(); ++i) {
            if (!all_[i].volume) continue;
            rays_[i] = all_[i].volume->rays->look(column + 0.5, row + 0.5, leastSeen, scratch_[i]);
            if (!(rays_[i].opacity >= leastSeen)) rays_[i] = {};
        }
    }
    /// What they saw, by layer.
    const std::vector<VolumeSeenOn>& rays() const { return rays_; }
    /// What is nearest in a pixel, its own surfaces and what the rays saw.
    void tell(std::uint32_t column, std::uint32_t row) {
        column_ = column;
        row_ = row;
        surfaces_.clear();
        for (std::size_t i = 0; i < all_.size(); ++i) {
            taken_[i] = 0.0;
            order_.own[i].at(column, row) = all_[i].surface ? meet(i) : ownOf(rays_[i]);
        }
        std::sort(surfaces_.begin(), surfaces_.end());
        follow();
        choose();
    }

  private:
    /// What a layer takes of the light in one go: a surface, or matter between two of them.
    struct Event {
        std::size_t layer;
        double taken, from, to;  // depths; of a surface the same
    };

    std::uint8_t meet(std::size_t i) {
        const auto& surface = *all_[i].surface;
        const float depth = surface.depth.at(column_, row_);
        if (!std::isfinite(depth)) return 0;
        surfaces_.emplace_back(depth, i);
        return surface.opacity.at(column_, row_);
    }
    static std::uint8_t ownOf(const VolumeSeenOn& ray) {
        return static_cast<std::uint8_t>(std::lround(255.0 * std::min(1.0, ray.opacity)));
    }

    /// Front to back.
    void follow() {
        events_.clear();
        left_ = 1.0;
        double depth = -HUGE_VAL;
        for (const auto& [surface, i] : surfaces_) {
            throughMatter(depth, static_cast<double>(surface));
            depth = static_cast<double>(surface);
            take(i, left_ * all_[i].surface->opacity.at(column_, row_) / 255.0, depth, depth);
        }
        throughMatter(depth, HUGE_VAL);
    }
    void take(std::size_t i, double taken, double from, double to) {
        if (!(taken > 0.0)) return;
        events_.push_back({i, taken, from, to});
        taken_[i] += taken;
        left_ -= taken;
    }
    /// Of several volumes each takes by its own optical depth there, the thickest first.
    void throughMatter(double from, double to) {
        thick_.clear();
        for (std::size_t i = 0; i < all_.size(); ++i) {
            if (!all_[i].volume || !(rays_[i].opacity > 0.0)) continue;
            const double before = VolumeRays::absorbedBefore(scratch_[i], from),
                         after = VolumeRays::absorbedBefore(scratch_[i], to);
            if (after > before) thick_.emplace_back((after - before) / (1.0 - before), i);
        }
        std::sort(thick_.begin(), thick_.end(), std::greater<>());
        for (const auto& [share, i] : thick_) take(i, left_ * share, from, to);
    }

    void choose() {
        const double lost = 1.0 - left_;
        order_.layer.at(column_, row_) = DepthOrder::nothing;
        if (!(lost >= leastLost)) return;
        double sum = 0.0;
        const auto half = std::find_if(events_.begin(), events_.end(), [&](const Event& event) {
            return (sum += event.taken) >= 0.5 * lost;
        });
        if (half == events_.end()) return;
        put(*half);
    }
    void put(const Event& event) {
        const std::size_t i = event.layer;
        const auto at = [&](auto& raster) -> auto& {
            return raster.at(column_, row_);
        };
        double depth = event.from, front = event.from;
        float tone = 0.0F;
        if (all_[i].volume) {
            const double before = VolumeRays::absorbedBefore(scratch_[i], event.from),
                         after = VolumeRays::absorbedBefore(scratch_[i], event.to);
            depth = VolumeRays::depthWhere(scratch_[i], std::lerp(before, after, 0.5));
            front = VolumeRays::depthWhere(scratch_[i], std::lerp(before, after, beginsAt));
            tone = toneAt(i, depth);
        } else {
            tone = static_cast<float>(at(all_[i].surface->tone)) / 255.0F;
        }
        if (!std::isfinite(depth) || !std::isfinite(front)) return;
        at(order_.layer) = static_cast<std::uint8_t>(i);
        at(order_.depth) = static_cast<float>(depth);
        at(order_.front) = static_cast<float>(front);
        at(order_.share) = static_cast<float>(taken_[i]);
        at(order_.tone) = tone;
    }
    float toneAt(std::size_t i, double depth) const {
        const auto& volume = *all_[i].volume;
        const auto& ray = rays_[i];
        if (volume.cells == nullptr) {
            const double code = volume.rays->codeAt(column_ + 0.5, row_ + 0.5, depth);
            const glm::dvec3 color = volume.transfer.color(volume.field->valueOf(code));
            return lightness(luminance(color) * ray.light / ray.opacity);
        }
        const auto& cells = *volume.cells;
        const glm::dvec3 inBox = volume.rays->boxPlace(column_ + 0.5, row_ + 0.5, depth);
        const glm::uvec3 cell(
            glm::clamp(inBox * glm::dvec3(cells.size), glm::dvec3(0.0), glm::dvec3(cells.size) - 0.5));
        return lightness(luminance(
            volume.transfer.color(static_cast<double>(cells.t[cells.index(cell.x, cell.y, cell.z)]))));
    }

    const std::vector<Participant>& all_;
    DepthOrder& order_;
    std::vector<VolumeRays::Scratch> scratch_;
    std::vector<VolumeSeenOn> rays_;
    std::vector<double> taken_;                            // of the pixel's light, by layer
    std::vector<std::pair<float, std::size_t>> surfaces_;  // by depth
    std::vector<std::pair<double, std::size_t>>
        thick_;  // what volumes absorb between two surfaces, the most first
    std::vector<Event> events_;
    double left_ = 1.0;
    std::uint32_t column_ = 0, row_ = 0;
};

/// What the depths of all that takes part differ by.
double extentOf(const Scene& scene, const FramePlan& plan) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (std::size_t i = 0; i < scene.view.layers.size(); ++i) {
        const Layer& layer = scene.view.layers[i];
        if (!hasDepth(layer)) continue;
        const Bounds bounds = layer.mesh() != nullptr     ? scene.layers[i].mesh->bounds()
                              : layer.hybrid() != nullptr ? scene.layers[i].hybrid->bounds()
                                                          : plotBounds;
        const Bounds inEye = bounds.transformed(plan.camera.worldToEye() * layer.transform);
        low = std::min(low, std::max(-inEye.max.z, nearLimit(plan.camera)));
        high = std::max(high, -inEye.min.z);
    }
    return std::max(high - low, 1e-300);
}

/// Finds the order of depth, first with a ray of each volume for a block of pixels.
class OrderMaker {
  public:
    OrderMaker(const std::vector<Participant>& all, const FramePlan& plan, double pixels, double extent,
               const std::stop_token& stop)
        : all_(all),
          plan_(plan),
          blocks_(plan, pixels),
          extent_(extent),
          stop_(stop),
          shared_(sharedBlocks(all, blocks_, contrastReach(pixels))),
          order_(plan.width, plan.height, all.size()) {
        order_.extent = extent;
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (all[i].surface) continue;
            opacity_.emplace_back(blocks_.width, blocks_.height);
            depth_.emplace_back(blocks_.width, blocks_.height);
        }
    }

    DepthOrder make() && {
        eachBlock([this](PixelLook& look, std::uint32_t x, std::uint32_t y) { first(look, x, y); });
        if (blocks_.side == 1 || isStopped(stop_)) return std::move(order_);
        // All are told before any is looked at again.
        for (std::uint32_t y = 0; y < blocks_.height; ++y) {
            for (std::uint32_t x = 0; x < blocks_.width; ++x) {
                if (shared_.at(x, y) != 0 && isCoarse(x, y)) shared_.at(x, y) = again;
            }
        }
        eachBlock([this](PixelLook& look, std::uint32_t x, std::uint32_t y) {
            if (shared_.at(x, y) == again) closer(look, x, y);
        });
        return std::move(order_);
    }

  private:
    static constexpr std::uint8_t again = 2;

    template <class Body>
    void eachBlock(const Body& body) {
        forInTurns(std::uint32_t{0}, blocks_.height, [&](std::uint32_t y) {
            if (isStopped(stop_)) return;
            PixelLook look(all_, order_);
            for (std::uint32_t x = 0; x < blocks_.width; ++x) {
                if (shared_.at(x, y) != 0) body(look, x, y);
            }
        });
    }
    template <class Take>
    void eachPixel(std::uint32_t x, std::uint32_t y, const Take& take) const {
        const auto pixels = blocks_.pixels(x, y, plan_);
        for (auto row = pixels.top; row < pixels.bottom; ++row) {
            for (auto column = pixels.left; column < pixels.right; ++column) take(column, row);
        }
    }
    void first(PixelLook& look, std::uint32_t x, std::uint32_t y) {
        const auto pixels = blocks_.pixels(x, y, plan_);
        look.aim((pixels.left + pixels.right) / 2, (pixels.top + pixels.bottom) / 2);
        std::size_t volume = 0;
        for (std::size_t i = 0; i < all_.size(); ++i) {
            if (all_[i].surface) continue;
            opacity_[volume].at(x, y) = static_cast<float>(look.rays()[i].opacity);
            depth_[volume++].at(x, y) = static_cast<float>(look.rays()[i].depth);
        }
        eachPixel(x, y, [&](auto column, auto row) { look.tell(column, row); });
    }
    /// By rays half a block apart.
    void closer(PixelLook& look, std::uint32_t x, std::uint32_t y) {
        const std::uint32_t half = blocks_.side / 2;
        const auto pixels = blocks_.pixels(x, y, plan_);
        for (auto top = pixels.top; top < pixels.bottom; top += half) {
            for (auto left = pixels.left; left < pixels.right; left += half) {
                look.aim(left, top);
                for (auto row = top; row < std::min(top + half, pixels.bottom); ++row) {
                    for (auto column = left; column < std::min(left + half, pixels.right); ++column)
                        look.tell(column, row);
                }
            }
        }
    }
    /// Whether layers meet in a block or beside it, and volumes are not alike there.
    bool isCoarse(std::uint32_t x, std::uint32_t y) const {
        bool differ = false, meet = false;
        std::uint8_t layer = DepthOrder::nothing;
        eachAround(blocks_, x, y, [&](auto i, auto j) {
            for (std::size_t k = 0; k < opacity_.size(); ++k)
                differ = differ || this->differ(k, {x, y}, {i, j});
            eachPixel(i, j, [&](auto column, auto row) {
                const auto here = order_.layer.at(column, row);
                meet = meet || (here != layer && here != DepthOrder::nothing && layer != DepthOrder::nothing);
                if (here != DepthOrder::nothing) layer = here;
            });
        });
        return differ && meet;
    }
    bool differ(std::size_t volume, const glm::uvec2& one, const glm::uvec2& other) const {
        const float a = opacity_[volume].at(one.x, one.y), b = opacity_[volume].at(other.x, other.y);
        if (std::abs(a - b) > static_cast<float>(otherOpacity)) return true;
        if (!(a > 0.0F) || !(b > 0.0F)) return false;
        return std::abs(depth_[volume].at(one.x, one.y) - depth_[volume].at(other.x, other.y)) >
               static_cast<float>(otherDepth * extent_);
    }

    const std::vector<Participant>& all_;
    const FramePlan& plan_;
    const Blocks blocks_;
    const double extent_;
    const std::stop_token& stop_;
    Raster<std::uint8_t> shared_;  // of blocks: several layers are near, and it is looked at again
    std::vector<Raster<float>> opacity_, depth_;  // of volumes, by block
    DepthOrder order_;
};

}  // namespace

bool hasDepth(const Layer& layer) {
    if (!(layer.opacity > 0.0)) return false;
    if (layer.mesh() != nullptr) return !layer.mesh()->wire();
    return layer.hybrid() != nullptr || layer.particles() != nullptr;
}

bool contrastsDepth(const View& view) {
    return view.depthContrast > 0.0 && std::count_if(view.layers.begin(), view.layers.end(), hasDepth) > 1;
}

std::shared_ptr<const FragmentMaker> depthContrastOf(const Scene& scene, const FramePlan& plan,
                                                     const std::stop_token& stop) {
    if (!contrastsDepth(scene.view)) return nullptr;
    const auto all = participantsOf(scene, plan, stop);
    if (all.size() < 2 || isStopped(stop)) return nullptr;
    const double pixels = plan.height / usualLines;
    const auto order = OrderMaker(all, plan, pixels, extentOf(scene, plan), stop).make();
    if (isStopped(stop)) return nullptr;
    constexpr double rim = 0.35;
    return contrastOf(order,
                      {.amount = scene.view.depthContrast,
                       .pixels = pixels,
                       .rim = isLight(plan.background) ? rim : 0.0,
                       .background = glm::vec3(plan.background)},
                      stop);
}

}  // namespace mote::render
