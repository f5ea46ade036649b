// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/layers/transfer_functions.h"

#include <algorithm>
#include <utility>

#include "protocol/scene/particles_style.h"

namespace mote::client {

TransferFunctions::TransferFunctions() {
    read(proto::ParticlesStyle());
}

void TransferFunctions::follow() {
    if (linked_) points_.take(linkedFraction(Curve::create(volume_.knots()).value()).knots());
}

void TransferFunctions::setOfPlot(const Curve& volume, const Curve& points) {
    if (chosen_) return;
    volume_.take(volume.knots());
    points_.take(points.knots());
    linked_ = false;
}

void TransferFunctions::take(std::vector<Curve::Knot> volume, std::vector<Curve::Knot> points) {
    volume_.take(std::move(volume));
    points_.take(std::move(points));
    linked_ = false;
    chosen_ = true;
}

void TransferFunctions::setLinked(bool linked) {
    chosen_ = true;
    if (linked == linked_) return;
    linked_ = linked;
    if (!linked && !ownPoints_.empty()) points_.take(std::exchange(ownPoints_, {}));
    auto own = points_.knots();
    follow();
    if (linked && own != points_.knots()) ownPoints_ = std::move(own);
}

void TransferFunctions::move(Which which, std::size_t knot, Curve::Knot to) {
    chosen_ = true;
    if (isOpposite(which)) {
        moveOpposite(knot, to);
    } else {
        edited(which).move(knot, to);
    }
    follow();
}

/// The volume's greatest opacity is what fractions are measured by, so a knot that alone holds it moves
/// sideways only.
void TransferFunctions::moveOpposite(std::size_t knot, Curve::Knot to) {
    points_.move(knot, to);
    const Curve::Knot held = points_.knots()[knot];
    const auto& all = volume_.knots();
    double most = 0.0;
    for (const auto& each : all) most = std::max(most, each.y);
    const auto holders =
        std::count_if(all.begin(), all.end(), [&](const auto& each) { return each.y >= most; });
    const bool alone = all[knot].y >= most && holders == 1;
    volume_.move(knot, {held.x, alone ? most : most * (1.0 - held.y)});
}

std::size_t TransferFunctions::insert(Which which, Curve::Knot at) {
    chosen_ = true;
    auto& curve = edited(which);
    const std::size_t before = curve.knots().size();
    const double y = isOpposite(which) ? Curve::create(curve.knots()).value()(at.x) : at.y;
    const std::size_t knot = curve.insert({at.x, y});
    follow();
    if (isOpposite(which) && curve.knots().size() > before) move(which, knot, at);
    return knot;
}

void TransferFunctions::remove(Which which, std::size_t knot) {
    chosen_ = true;
    edited(which).remove(knot);
    follow();
}

void TransferFunctions::write(proto::ParticlesStyle& style) const {
    style.mutable_volume()->clear_curve();
    style.mutable_points()->clear_curve();
    style.mutable_points()->clear_linked();
    if (!chosen_) return;
    for (const auto& knot : volume_.knots()) {
        auto* written = style.mutable_volume()->add_curve();
        written->set_density(knot.x);
        written->set_opacity(knot.y);
    }
    style.mutable_points()->set_linked(linked_);
    if (linked_) return;
    for (const auto& knot : points_.knots()) {
        auto* written = style.mutable_points()->add_curve();
        written->set_density(knot.x);
        written->set_fraction(knot.y);
    }
}

void TransferFunctions::read(const proto::ParticlesStyle& style) {
    const auto parsed = particlesStyleOf(parseParticlesStyle(style).value());
    volume_.take(parsed.volumeOpacity.knots());
    points_.take(parsed.pointFraction.knots());
    linked_ = !style.points().has_linked() || style.points().linked();
    if (!linked_) ownPoints_.clear();
    chosen_ = !parsed.curveByPlot;
}

}  // namespace mote::client
