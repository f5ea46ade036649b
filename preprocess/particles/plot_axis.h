// SPDX-License-Identifier: GPL-3.0-or-later
//
// PlotAxis: a coordinate or derived quantity that a plot can have along an axis: its name, its unit, the
// columns it is made from and its values. Pure functions.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/readers/particle_source.h"
#include "protocol/scene/error.h"

namespace mote::prep {

enum class AxisKind { x, y, z, t, px, py, pz, r, theta, xp, yp, pr, delta, gamma, energy };

struct PlotAxis {
    AxisKind kind;
    std::string_view name;        ///< as in --axes
    std::string_view unit;        ///< "m", "eV/c", "s", "rad", "eV" or "1"
    std::vector<Column> columns;  ///< what it is made from, weight aside
    bool needsMass = false;

    /// Whether its values are a column as it is.
    bool isColumn() const { return kind <= AxisKind::pz; }
};

/// What some axes need besides a particle's own columns.
struct AxisContext {
    double mass = 0.0;          ///< eV/c^2
    double meanMomentum = 0.0;  ///< eV/c, weighted mean of |p| over the step's live particles; for delta
};

/// Errors: invalidArgument, with all names.
Result<PlotAxis> findAxis(std::string_view name);

/// Whether a run can give the axis. Errors: notFound, naming the axis, what it lacks and what there is.
Status checkAxis(const PlotAxis& axis, const ParticleSource& source);

/// The axis' value of each of the chunk's particles; not finite where it has none (px/pz at pz = 0). `out`
/// has the chunk's size. Uses all threads of the calling arena.
void evaluateAxis(const PlotAxis& axis, const ParticleChunk& chunk, const AxisContext& context,
                  std::span<double> out);

/// |p| of particle i of a chunk with px, py and pz, eV/c.
double momentum(const ParticleChunk& chunk, std::size_t i);

}  // namespace mote::prep
