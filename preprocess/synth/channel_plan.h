// SPDX-License-Identifier: GPL-3.0-or-later
//
// ChannelPlan: everything that is the same for all particles, worked out once: the core's envelope along the
// channel and, from it, a list of exact linear maps and space-charge kicks, with the places where the beam is
// dumped. Its size does not depend on the number of particles. Immutable once made; read from any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/synth/envelope.h"
#include "preprocess/synth/fodo_channel.h"

namespace mote::prep {

/// A map, then a kick.
struct PlanStage {
    ChannelMap map{};
    CoreKick kick{};
};

/// A place where the beam is written.
struct PlanDump {
    double place = 0.0;             ///< m along the channel
    std::uint64_t slice = 0;        ///< kicks before it
    std::vector<PlanStage> stages;  ///< from the dump before
    ChannelMap last{};              ///< the half slice after the last stage
    Envelope core{};                ///< the core here
};

struct ChannelPlan {
    BeamDesign design;
    BeamKinematics beam;
    std::array<double, 3> emittance{};           ///< m rad, of the core: 5 times the rms one
    double sliceLength = 0.0;                    ///< m
    std::uint64_t slices = 0;                    ///< of the whole channel
    Envelope matched{};                          ///< at the channel's start
    std::array<double, 3> zeroCurrentAdvance{};  ///< rad a period
    std::array<double, 3> depressedAdvance{};    ///< rad a period, matched core
    double flattest = 1.0;                       ///< greatest ratio of two semi-axes of the core on its way
    std::vector<PlanDump> dumps;
};

/// A slice is half a quadrupole long. Twice as many would move the depressed phase advance by 5e-4 of itself.
inline constexpr int slicesPerPeriod = 12;
inline constexpr int channelPeriods = 40;

/// `steps` dumps (1 to 10^6): the first at the start, the last at the end of channelPeriods periods, the
/// others evenly between, on slices; where there are more dumps than slices, slices are divided. A single
/// step is the end: the beam with its halo. Errors: invalidArgument if the design has no matched beam or
/// its core does not stay together.
Result<ChannelPlan> planChannel(const BeamDesign& design, std::uint32_t steps);

}  // namespace mote::prep
