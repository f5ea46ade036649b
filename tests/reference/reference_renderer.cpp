// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reference/reference_renderer.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <span>

#include "protocol/base/mote_check.h"
#include "protocol/scene/srgb.h"
#include "server/render/layers/particles/lower_particles.h"
#include "tests/reference/hybrid_field.h"
#include "tests/reference/point_hits.h"
#include "tests/reference/volume_field.h"

namespace mote::reference {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();
// What is behind less transmittance than this changes no pixel by a thousandth of an 8-bit step.
constexpr double opaque = 1e-13;

/// A pixel's ray in the space of one layer, told by depth: at(d) is where the ray has depth d.
struct LayerRay {
    glm::dvec3 origin;
    glm::dvec3 perDepth;
    double enter = 0.0;  ///< depth at which the ray enters the box, not nearer than what is seen
    double leave = 0.0;  ///< not greater than enter: it misses the box

    glm::dvec3 at(double depth) const { return origin + depth * perDepth; }
};

void clip(LayerRay& ray, const std::vector<HalfSpace>& within) {
    for (const auto& side : within) {
        // How far inside: height + depth * speed.
        const double height = glm::dot(side.normal, ray.origin) - side.distance;
        const double speed = glm::dot(side.normal, ray.perDepth);
        if (speed > 0.0) ray.enter = std::max(ray.enter, -height / speed);
        if (speed < 0.0) ray.leave = std::min(ray.leave, -height / speed);
        if (speed == 0.0 && height < 0.0) ray.leave = -endless;
    }
}

class Renderer {
  public:
    Renderer(const render::Scene& scene, const Options& options)
        : view_(scene.view), hits_(scene, options), samplesPerCell_(options.samplesPerCell) {
        for (std::size_t i = 0; i < view_.layers.size(); ++i) {
            const Layer& layer = view_.layers[i];
            if (!(layer.opacity > 0.0)) continue;
            if (layer.particles() != nullptr)
                fields_.push_back(
                    std::make_unique<VolumeField>(volumeOf(scene, i, render::particlesStyleOf(scene, i))));
            else if (layer.hybrid() != nullptr && !showsSight(layer))
                fields_.push_back(
                    std::make_unique<HybridField>(*scene.layers[i].hybrid, layer, view_.camera));
            else
                continue;
            opacity_.push_back(layer.opacity);
            within_.push_back(fields_.back()->within());
            const auto clips = layer.clips();
            within_.back().insert(within_.back().end(), clips.begin(), clips.end());
            eyeToLayer_.push_back(glm::inverse(view_.camera.worldToEye() * layer.transform));
        }
    }

    void drawRow(std::uint32_t row, std::span<glm::dvec3> pixels) const {
        const auto hits = hits_.row(row);
        for (std::uint32_t column = 0; column < view_.width; ++column)
            pixels[column] = pixel(column, row, hits.of(column));
    }

    const std::vector<std::uint8_t>& ambiguous() const { return hits_.ambiguous(); }

  private:
    struct Light {
        glm::dvec3 color{0.0};
        double left = 1.0;  ///< transmittance of all that lies in front
    };

    glm::dvec3 pixel(std::uint32_t column, std::uint32_t row, std::span<const Hit> hits) const {
        const auto rays = raysThrough(column, row);
        Light light;
        double depth = -endless;
        for (const auto& hit : hits) {
            if (light.left <= opaque) break;
            gather(rays, depth, hit.depth, light);
            light.color += light.left * hit.alpha * hit.color;
            light.left *= 1.0 - hit.alpha;
            depth = hit.depth;
        }
        gather(rays, depth, endless, light);
        return light.color + light.left * view_.background;
    }

    std::vector<LayerRay> raysThrough(std::uint32_t column, std::uint32_t row) const {
        const double half = view_.camera.halfHeight();
        const double x = (2.0 * (column + 0.5) / view_.width - 1.0) * view_.aspect() * half;
        const double y = (1.0 - 2.0 * (row + 0.5) / view_.height) * half;
        const bool perspective = view_.camera.perspective();
        const glm::dvec4 origin = perspective ? glm::dvec4(0.0, 0.0, 0.0, 1.0) : glm::dvec4(x, y, 0.0, 1.0);
        const glm::dvec4 perDepth =
            perspective ? glm::dvec4(x, y, -1.0, 0.0) : glm::dvec4(0.0, 0.0, -1.0, 0.0);
        std::vector<LayerRay> rays;
        for (std::size_t i = 0; i < eyeToLayer_.size(); ++i) {
            LayerRay ray{glm::dvec3(eyeToLayer_[i] * origin), glm::dvec3(eyeToLayer_[i] * perDepth),
                         nearestDepth(view_.camera), endless};
            clip(ray, within_[i]);
            rays.push_back(ray);
        }
        return rays;
    }

    /// The volumes between two depths. It is cut where a ray enters or leaves a box, so that every step sees
    /// a continuous field.
    void gather(const std::vector<LayerRay>& rays, double from, double to, Light& light) const {
        std::vector<double> cuts;
        for (const auto& ray : rays) {
            if (ray.leave <= ray.enter) continue;
            for (const double cut : {std::max(ray.enter, from), std::min(ray.leave, to)}) {
                if (cut >= from && cut <= to) cuts.push_back(cut);
            }
        }
        std::sort(cuts.begin(), cuts.end());
        for (std::size_t i = 1; i < cuts.size(); ++i) march(rays, cuts[i - 1], cuts[i], light);
    }

    /// Midpoint rule for extinction and colour, exact exponential for what they do to the light.
    void march(const std::vector<LayerRay>& rays, double from, double to, Light& light) const {
        const double step = stepWithin(rays, 0.5 * (from + to));
        const double count = std::ceil((to - from) / step);
        for (double i = 0.0; i < count && light.left > opaque; ++i) {
            const double depth = from + (to - from) * (i + 0.5) / count;
            absorb(rays, depth, (to - from) / count, light);
        }
    }

    /// The depth of one sample among the layers that the ray is in; infinite where it is in none.
    double stepWithin(const std::vector<LayerRay>& rays, double depth) const {
        double step = endless;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (depth < rays[i].enter || depth > rays[i].leave) continue;
            step = std::min(step, fields_[i]->cellEdge() / (samplesPerCell_ * glm::length(rays[i].perDepth)));
        }
        return step;
    }

    void absorb(const std::vector<LayerRay>& rays, double depth, double thickness, Light& light) const {
        double extinction = 0.0;
        glm::dvec3 emission(0.0);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (depth < rays[i].enter || depth > rays[i].leave) continue;
            const VolumeMatter matter = fields_[i]->at(rays[i].at(depth));
            // Extinction is per length of layer space: here per depth.
            const double here = opacity_[i] * matter.extinction * glm::length(rays[i].perDepth);
            if (here <= 0.0) continue;
            extinction += here;
            emission += here * matter.color;
        }
        if (extinction <= 0.0) return;
        const double absorbed = -std::expm1(-extinction * thickness);
        light.color += light.left * absorbed / extinction * emission;
        light.left *= 1.0 - absorbed;
    }

    const View& view_;
    PointHits hits_;
    double samplesPerCell_;
    std::vector<std::unique_ptr<Volume>> fields_;
    std::vector<double> opacity_;  // of their layers
    std::vector<std::vector<HalfSpace>> within_;
    std::vector<glm::dmat4> eyeToLayer_;
};

}  // namespace

Picture render(const render::Scene& scene, const Options& options) {
    MOTE_CHECK(scene.layers.size() == scene.view.layers.size());
    const Renderer renderer(scene, options);
    Picture picture{scene.view.width, scene.view.height, {}, renderer.ambiguous()};
    picture.linear.resize(picture.ambiguous.size());
    oneapi::tbb::parallel_for(0U, picture.height, [&](std::uint32_t row) {
        renderer.drawRow(row,
                         std::span(picture.linear).subspan(std::size_t{row} * picture.width, picture.width));
    });
    return picture;
}

test::Image encode(const Picture& picture) {
    test::Image image{picture.width, picture.height, {}};
    for (const auto& color : picture.linear) {
        for (int i = 0; i < 3; ++i) {
            const double encoded = std::clamp(linearToSrgb(color[i]), 0.0, 1.0);
            image.pixels.push_back(static_cast<std::uint8_t>(std::lround(255.0 * encoded)));
        }
        image.pixels.push_back(255);
    }
    return image;
}

}  // namespace mote::reference
