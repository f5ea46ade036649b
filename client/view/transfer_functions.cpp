// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/transfer_functions.h"

#include <algorithm>

#include "client/view/knots.h"
#include "protocol/scene/particles_style.h"

namespace mote::client {
namespace {

double greatest(const std::vector<Curve::Knot>& knots) {
    double most = 0.0;
    for (const auto& knot : knots) most = std::max(most, knot.y);
    return most;
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
        own[knot] = heldKnot(own, knot, to, {});
        return follow();
    }
    // The opposite edit on the volume. Its greatest opacity is what fractions are measured by, so a knot that
    // alone holds it moves sideways only.
    to = heldKnot(points_, knot, to, {});
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
    const std::size_t index = knotPlace(own, at.x);
    if (own.size() >= mostKnots) return std::min(index, own.size() - 1);
    const double y = Curve::create(own).value()(at.x);
    own.insert(own.begin() + static_cast<std::ptrdiff_t>(index), {at.x, y});
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
