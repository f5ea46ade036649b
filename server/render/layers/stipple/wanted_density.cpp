// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/render/layers/stipple/wanted_density.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "protocol/scene/fields/facts.h"
#include "server/render/layers/stipple/tone.h"
#include "server/render/plan/frame_plan.h"
#include "server/render/plan/in_turns.h"

namespace mote::render {
namespace {

using Range = tbb::blocked_range<std::size_t>;
constexpr std::size_t grain = 2048;     // points a task
constexpr double shininess = 32.0;      // exponent of the highlight (Blinn)
constexpr double marginSpacings = 4.0;  // a dot's neighbours, and theirs

}  // namespace

SurfaceView::SurfaceView(const View& view, const glm::dmat4& transform)
    : layerToEye(view.camera.worldToEye() * transform),
      turnToEye(view.camera.worldToEye()),
      size(view.width, view.height),
      pixels(view.height / (2.0 * view.camera.halfHeight())),
      perspective(view.camera.perspective()),
      nearest(perspective ? nearShare * glm::length(view.camera.target - view.camera.eye)
                          : -std::numeric_limits<double>::infinity()) {
    const glm::dmat3 linear(layerToEye);
    // The cofactors; a mirror image keeps outside out.
    areaToEye = std::abs(glm::determinant(linear)) * glm::transpose(glm::inverse(linear));
}

glm::dvec3 SurfaceView::towardsEye(const glm::dvec3& inEye) const {
    return perspective ? -glm::normalize(inEye) : glm::dvec3(0.0, 0.0, 1.0);
}

glm::dvec2 SurfaceView::onScreen(const glm::dvec3& inEye) const {
    const double scale = perspective ? pixels / -inEye.z : pixels;
    return 0.5 * size + scale * glm::dvec2(inEye.x, -inEye.y);
}

double SurfaceView::pixelArea(const glm::dvec3& inEye, const glm::dvec3& area) const {
    if (!perspective) return pixels * pixels * std::abs(area.z);
    // The Jacobian of the projection x / z, y / z, along the surface.
    return pixels * pixels * std::abs(glm::dot(area, inEye) / (inEye.z * inEye.z * inEye.z));
}

WantedDensity::WantedDensity(const StippleSurface& surface, const StippleStyle& style,
                             const SurfaceView& view)
    : surface_(surface),
      parts_(lightOf(style.light())),
      gamma_(style.gamma()),
      denseDark_(denseInDark(style)),
      byTone_(style.value() == "tone"),
      view_(view),
      light_(parts_.fixed ? view.turnToEye * parts_.direction : parts_.direction),
      lightInLayer_(glm::normalize(glm::inverse(glm::dmat3(view.layerToEye)) * light_)),
      // Evenly spaced points stand on a hexagonal grid, one in sqrt(3) / 2 of the square of their distance.
      fullDensity_(densityOfSpacing(lengthOf(style, style.kSpacingPixelsFieldNumber))),
      margin_(marginSpacings * lengthOf(style, style.kSpacingPixelsFieldNumber)) {}

double WantedDensity::brightness(const glm::dvec3& normal, const glm::dvec3& towardsEye, bool lit) const {
    const Light& light = parts_;
    if (!lit) return std::min(light.ambient, 1.0);
    const double diffuse = std::max(glm::dot(normal, light_), 0.0);
    double sum = light.ambient + light.diffuse * diffuse;
    if (light.specular > 0.0 && diffuse > 0.0) {
        const double half = glm::dot(normal, glm::normalize(light_ + towardsEye));
        sum += light.specular * std::pow(std::max(half, 0.0), shininess);
    }
    return std::min(sum, 1.0);
}

double WantedDensity::tone(double brightness) const {
    const double bright = gamma_ == 1.0 ? brightness : std::pow(brightness, gamma_);
    return denseDark_ ? 1.0 - bright : bright;
}

WantedDensity::Wanted WantedDensity::at(std::size_t point) const {
    const StippleReplay& replay = surface_.replay();
    const glm::dvec3 place = view_.toEye(replay.position(point));
    if (!view_.inFront(place)) return {};
    const glm::dvec2 screen = view_.onScreen(place);
    if (!(screen.x > -margin_ && screen.y > -margin_ && screen.x < view_.size.x + margin_ &&
          screen.y < view_.size.y + margin_)) {
        return {};
    }
    const glm::dvec3 area = view_.areaToEye * glm::dvec3(replay.normal(point));
    const glm::dvec3 towardsEye = view_.towardsEye(place);
    glm::dvec3 normal = glm::normalize(area);
    if (glm::dot(normal, towardsEye) < 0.0) normal = -normal;  // both sides of a sheet can be seen
    const double wanted = fullDensity_ * view_.pixelArea(place, area) / surface_.density();
    const auto asked = [&](bool lit) {
        const double share = tone(brightness(normal, towardsEye, lit));
        return Wanted{static_cast<float>(share), static_cast<float>(share * wanted)};
    };
    const Wanted lit = asked(true);
    if (!parts_.shadow || glm::dot(normal, light_) <= 0.0) return lit;
    const Wanted dark = asked(false);
    // A ray only if it decides.
    const bool decides = byTone_ || replay.selects(point, lit.share) != replay.selects(point, dark.share);
    if (!decides) return lit;
    const bool shaded = surface_.hides(replay.position(point), replay.normal(point), lightInLayer_, INFINITY);
    return shaded ? dark : lit;
}

std::vector<float> WantedDensity::shares() const {
    std::vector<float> shares(surface_.replay().size());
    forRangesInTurns(shares.size(), grain, [&](const Range& range) {
        for (auto i = range.begin(); i != range.end(); ++i) shares[i] = at(i).share;
    });
    return shares;
}

}  // namespace mote::render
