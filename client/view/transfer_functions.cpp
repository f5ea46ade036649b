// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/transfer_functions.h"

#include <algorithm>

#include "protocol/scene/particles_style.h"

namespace mote::client {
namespace {

constexpr std::size_t mostKnots = 64;  // more cannot be told apart by hand; the schema allows 256

double greatest(const std::vector<Curve::Knot>& knots) {
    double most = 0.0;
    for (const auto& knot : knots) most = std::max(most, knot.y);
    return most;
}

Curve::Knot between(const std::vector<Curve::Knot>& knots, std::size_t index, Curve::Knot to) {
    const double least = index > 0 ? knots[index - 1].x : 0.0;
    const double most = index + 1 < knots.size() ? knots[index + 1].x : 1.0;
    return {std::clamp(to.x, least, most), std::clamp(to.y, 0.0, 1.0)};
}

}  // namespace

TransferFunctions::TransferFunctions() {
    read(proto::ParticlesStyle());
}

void TransferFunctions::follow() {
    if (linked_) points_ = linkedFraction(Curve::create(volume_).value()).knots();
}

void TransferFunctions::setLinked(bool linked) {
    linked_ = linked;
    follow();
}

void TransferFunctions::move(Which which, std::size_t knot, Curve::Knot to) {
    if (which == Which::volume || !linked_) {
        auto& own = which == Which::volume ? volume_ : points_;
        own[knot] = between(own, knot, to);
        return follow();
    }
    // The opposite edit on the volume. Its greatest opacity is what fractions are measured by, so a knot that
    // alone holds it moves sideways only.
    to = between(points_, knot, to);
    auto others = volume_;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(knot));
    const double most = greatest(volume_);
    const bool holdsMost = volume_[knot].y >= most && greatest(others) < most;
    volume_[knot] = {to.x, holdsMost ? most : most * (1.0 - to.y)};
    follow();
}

std::size_t TransferFunctions::insert(Which which, Curve::Knot at) {
    const Which target = linked_ ? Which::volume : which;
    auto& own = target == Which::volume ? volume_ : points_;
    const auto above = std::upper_bound(own.begin(), own.end(), at.x,
                                        [](double x, const Curve::Knot& k) { return x < k.x; });
    const auto index = static_cast<std::size_t>(above - own.begin());
    if (own.size() >= mostKnots) return std::min(index, own.size() - 1);
    const double y = Curve::create(own).value()(at.x);
    own.insert(above, {at.x, y});
    follow();
    move(which, index, at);
    return index;
}

void TransferFunctions::remove(Which which, std::size_t knot) {
    auto& own = linked_ || which == Which::volume ? volume_ : points_;
    if (own.size() < 2) return;
    own.erase(own.begin() + static_cast<std::ptrdiff_t>(knot));
    follow();
}

void TransferFunctions::write(proto::ParticlesStyle& style) const {
    style.mutable_volume()->clear_curve();
    for (const auto& knot : volume_) {
        auto* written = style.mutable_volume()->add_curve();
        written->set_density(knot.x);
        written->set_opacity(knot.y);
    }
    style.mutable_points()->set_linked(linked_);
    style.mutable_points()->clear_curve();
    if (linked_) return;
    for (const auto& knot : points_) {
        auto* written = style.mutable_points()->add_curve();
        written->set_density(knot.x);
        written->set_fraction(knot.y);
    }
}

void TransferFunctions::read(const proto::ParticlesStyle& style) {
    const auto parsed = parseParticlesStyle(style).value();
    volume_ = parsed.volumeOpacity.knots();
    points_ = parsed.pointFraction.knots();
    linked_ = !style.points().has_linked() || style.points().linked();
}

}  // namespace mote::client
