// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/synth/fodo_channel.h"

#include <algorithm>
#include <cmath>

namespace mote::prep {

BeamKinematics kinematics(const BeamDesign& design) {
    BeamKinematics result;
    const double excess = design.kineticEnergy / protonMassEv;  // gamma - 1, kept apart against cancellation
    const double betaGamma = std::sqrt(excess * (excess + 2.0));
    result.gamma = 1.0 + excess;
    result.beta = betaGamma / result.gamma;
    result.momentum = protonMassEv * betaGamma;
    result.particlesPerBunch = design.current / (design.rfFrequency * elementaryCharge);
    result.perveance = result.particlesPerBunch * classicalProtonRadius / (betaGamma * betaGamma);
    return result;
}

BeamDesign mismatched(BeamDesign design, double mismatch) {
    const double excess = mismatch - 1.0;
    design.mismatch = {1.0 + 1.4 * excess, 1.0 + 0.6 * excess, 1.0 + 1.2 * excess};
    return design;
}

PlaneMap PlaneMap::after(const PlaneMap& earlier) const {
    return {uu * earlier.uu + up * earlier.pu, uu * earlier.up + up * earlier.pp,
            pu * earlier.uu + pp * earlier.pu, pu * earlier.up + pp * earlier.pp};
}

PlaneMap constantFocusing(double k, double length) {
    // cos and sin / sqrt(k), or their hyperbolic forms: one series serves both signs, and it needs no
    // mathematical library, whose last bit differs from machine to machine. |k| length^2 < 1 in any lattice
    // of ours.
    const double argument = -k * length * length;
    double cosine = 1.0, sine = 1.0, cosineTerm = 1.0, sineTerm = 1.0;
    for (int n = 1; n <= 14; ++n) {
        cosineTerm *= argument / ((2.0 * n - 1.0) * (2.0 * n));
        sineTerm *= argument / ((2.0 * n) * (2.0 * n + 1.0));
        cosine += cosineTerm;
        sine += sineTerm;
    }
    return {cosine, sine * length, -k * sine * length, cosine};
}

FodoChannel::FodoChannel(const BeamDesign& design) : periodLength_(design.periodLength) {
    const double rigidity = kinematics(design).momentum / speedOfLight;  // T m
    const double quadrupole = design.quadrupoleGradient / rigidity;
    const double half = 0.5 * design.quadrupoleLength;
    const double drift = 0.5 * periodLength_ - design.quadrupoleLength;
    const std::array<double, 5> lengths{half, drift, 2.0 * half, drift, half};
    const std::array<double, 5> strengths{quadrupole, 0.0, -quadrupole, 0.0, quadrupole};
    const double rf = design.rfFocusing;
    double begin = 0.0;
    for (std::size_t i = 0; i < lengths.size(); ++i) {
        // div F = 0 in the gap: what the rf focuses along, it defocuses across, half in each plane.
        elements_.push_back({begin, lengths[i], {strengths[i] - 0.5 * rf, -strengths[i] - 0.5 * rf, rf}});
        begin += lengths[i];
    }
}

ChannelMap FodoChannel::map(double begin, double end) const {
    ChannelMap total{};
    const auto firstPeriod = static_cast<long>(std::floor(begin / periodLength_));
    for (long period = firstPeriod; period * periodLength_ < end; ++period) {
        for (const ChannelElement& element : elements_) {
            const double from = std::max(begin, period * periodLength_ + element.begin);
            const double to = std::min(end, period * periodLength_ + element.begin + element.length);
            if (to <= from) continue;
            for (std::size_t plane = 0; plane < 3; ++plane) {
                total[plane] = constantFocusing(element.focusing[plane], to - from).after(total[plane]);
            }
        }
    }
    return total;
}

double FodoChannel::phaseAdvance(std::size_t plane) const {
    const PlaneMap period = map(0.0, periodLength_)[plane];
    return std::acos(std::clamp(0.5 * (period.uu + period.pp), -1.0, 1.0));
}

}  // namespace mote::prep
