// SPDX-License-Identifier: GPL-3.0-or-later
#include "preprocess/particles/plot_axis.h"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <array>
#include <cmath>

namespace mote::prep {
namespace {

constexpr std::array<std::string_view, 8> namesOfColumns{"x", "y", "z", "t", "px", "py", "pz", "weight"};

std::vector<PlotAxis> makeAxes() {
    using enum Column;
    return {
        {AxisKind::x, "x", "m", {x}},
        {AxisKind::y, "y", "m", {y}},
        {AxisKind::z, "z", "m", {z}},
        {AxisKind::t, "t", "s", {t}},
        {AxisKind::px, "px", "eV/c", {px}},
        {AxisKind::py, "py", "eV/c", {py}},
        {AxisKind::pz, "pz", "eV/c", {pz}},
        {AxisKind::r, "r", "m", {x, y}},
        {AxisKind::theta, "theta", "rad", {x, y}},
        {AxisKind::xp, "xp", "rad", {px, pz}},
        {AxisKind::yp, "yp", "rad", {py, pz}},
        {AxisKind::pr, "pr", "eV/c", {x, y, px, py}},
        {AxisKind::delta, "delta", "1", {px, py, pz}},
        {AxisKind::gamma, "gamma", "1", {px, py, pz}, true},
        {AxisKind::energy, "energy", "eV", {px, py, pz}, true},
    };
}

/// (x px + y py) / r, and on the axis its limit for a particle that leaves it.
double radialMomentum(double x, double y, double px, double py) {
    const double r = std::hypot(x, y);
    return r > 0.0 ? (x * px + y * py) / r : std::hypot(px, py);
}

double kineticEnergy(double p, double mass) {
    if (mass == 0.0) return p;  // of photons
    // sqrt(p^2 + m^2) - m without the difference of two large numbers.
    return p * (p / (std::hypot(p, mass) + mass));
}

template <class Value>
void fill(std::span<double> out, Value value) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, out.size(), 1 << 14), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) out[i] = value(i);
    });
}

void evaluatePosition(AxisKind kind, const ParticleChunk& chunk, std::span<double> out) {
    const auto& x = chunk[Column::x];
    const auto& y = chunk[Column::y];
    const auto& px = chunk[Column::px];
    const auto& py = chunk[Column::py];
    const auto& pz = chunk[Column::pz];
    if (kind == AxisKind::r) return fill(out, [&](std::size_t i) { return std::hypot(x[i], y[i]); });
    if (kind == AxisKind::theta) return fill(out, [&](std::size_t i) { return std::atan2(y[i], x[i]); });
    if (kind == AxisKind::xp) return fill(out, [&](std::size_t i) { return px[i] / pz[i]; });
    if (kind == AxisKind::yp) return fill(out, [&](std::size_t i) { return py[i] / pz[i]; });
    fill(out, [&](std::size_t i) { return radialMomentum(x[i], y[i], px[i], py[i]); });
}

}  // namespace

double momentum(const ParticleChunk& chunk, std::size_t i) {
    return std::hypot(chunk[Column::px][i], chunk[Column::py][i], chunk[Column::pz][i]);
}

Result<PlotAxis> findAxis(std::string_view name) {
    std::string names;
    for (auto& axis : makeAxes()) {
        if (axis.name == name) return std::move(axis);
        names += fmt::format("{}{}", names.empty() ? "" : ", ", axis.name);
    }
    return Error{ErrorCode::invalidArgument, "axes",
                 fmt::format("\"{}\" is not an axis; axes are {}", name.substr(0, 40), names)};
}

Status checkAxis(const PlotAxis& axis, const ParticleSource& source) {
    std::string present;
    std::string missing;
    for (std::size_t i = 0; i < namesOfColumns.size(); ++i) {
        if (source.has(static_cast<Column>(i)))
            present += fmt::format("{}{}", present.empty() ? "" : ", ", namesOfColumns[i]);
    }
    for (const auto column : axis.columns) {
        if (source.has(column)) continue;
        missing += fmt::format("{}{}", missing.empty() ? "" : ", ",
                               namesOfColumns[static_cast<std::size_t>(column)]);
    }
    const auto where = fmt::format("axis {}", axis.name);
    if (!missing.empty()) {
        return Error{ErrorCode::notFound, where,
                     fmt::format("needs {}, which the run does not have; it has {}", missing, present)};
    }
    // The energy of a photon is p c; no other species is without a mass.
    const bool photons = axis.kind == AxisKind::energy && source.species() == "photon";
    if (axis.needsMass && !(source.mass() > 0.0) && !photons) {
        return Error{
            ErrorCode::notFound, where,
            fmt::format("needs the particles' mass, which the run does not give (for IMPACT files: --mass); "
                        "it has {}",
                        present)};
    }
    return success();
}

void evaluateAxis(const PlotAxis& axis, const ParticleChunk& chunk, const AxisContext& context,
                  std::span<double> out) {
    switch (axis.kind) {
        case AxisKind::delta:
            return fill(out, [&](std::size_t i) {
                return (momentum(chunk, i) - context.meanMomentum) / context.meanMomentum;
            });
        case AxisKind::gamma:
            return fill(out,
                        [&](std::size_t i) { return std::hypot(1.0, momentum(chunk, i) / context.mass); });
        case AxisKind::energy:
            return fill(out, [&](std::size_t i) { return kineticEnergy(momentum(chunk, i), context.mass); });
        case AxisKind::r:
        case AxisKind::theta:
        case AxisKind::xp:
        case AxisKind::yp:
        case AxisKind::pr:
            return evaluatePosition(axis.kind, chunk, out);
        default:
            std::copy_n(chunk[axis.columns.front()].begin(), out.size(), out.begin());
    }
}

}  // namespace mote::prep
