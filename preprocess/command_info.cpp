// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <memory>

#include "preprocess/command_line.h"
#include "protocol/scene/json.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

void printParticles(const proto::Manifest& manifest) {
    const auto& particles = manifest.particles();
    for (const auto& input : manifest.request().particles().inputs()) fmt::print("input    {}\n", input);
    for (const auto& axis : particles.axes()) {
        fmt::print("axis     {} from {:.6g} to {:.6g} {}\n", axis.name(), axis.min(), axis.max(),
                   axis.unit());
    }
    const auto size = 1U << particles.volume_level();
    fmt::print("volume   {0} x {0} x {0}\noctree   at most {1} particles a leaf, to level {2}\n", size,
               particles.leaf_capacity(), particles.max_level());
    fmt::print("density  {:.4g} to {:.4g}\n\n", particles.density_min(), particles.density_max());
    fmt::print("{:>6} {:>10} {:>12} {:>12} {:>9} {:>9} {:>9} {:>12}\n", "step", "iteration", "time/s",
               "particles", "lost", "invalid", "outside", "weight");
    for (int i = 0; i < particles.steps_size(); ++i) {
        const auto& step = particles.steps(i);
        fmt::print("{:>6} {:>10} {:>12.5g} {:>12} {:>9} {:>9} {:>9} {:>12.5g}\n", i, step.iteration(),
                   step.time(), step.particles(), step.lost(), step.invalid(), step.outside(),
                   step.total_weight());
    }
}

void printStipple(const proto::Manifest& manifest) {
    const auto& stipple = manifest.stipple();
    const bool plane = stipple.domain() == proto::StippleManifest::PLANE;
    if (!plane) fmt::print("mesh     {}\n", manifest.request().stipple().mesh());
    fmt::print("domain   {}, area {:.6g}\n", plane ? "periodic unit square" : "surface", stipple.area());
    fmt::print("points   {}, {} of them locked\n", stipple.points(), stipple.locked());
    fmt::print("moves    {}, {:.1f} a point\n", stipple.moves(),
               static_cast<double>(stipple.moves()) / static_cast<double>(stipple.points()));
    fmt::print("rings    {}, relaxation {:.3g}\nseed     {}\n", stipple.rings(), stipple.relaxation(),
               stipple.seed());
}

void printImage(const proto::Manifest& manifest) {
    const auto& image = manifest.image();
    fmt::print("input    {}\n", manifest.request().image().input());
    fmt::print("image    {} x {} pixels, from {} {}{}\n", image.width(), image.height(),
               image.color() ? "colours" : "grey", image.color_space(),
               image.transparent() ? ", laid on white" : "");
    if (image.invalid() > 0) fmt::print("invalid  {} pixels, taken as white\n", image.invalid());
}

void printMesh(const proto::MeshManifest& mesh) {
    fmt::print("surface  {} vertices, {} triangles, {} edges, area {:.6g}\n", mesh.vertices(),
               mesh.triangles(), mesh.edges(), mesh.area());
    fmt::print("bounds   [{:.6g}] to [{:.6g}]\n", fmt::join(mesh.bounds_min(), ", "),
               fmt::join(mesh.bounds_max(), ", "));
}

std::string sizeText(const google::protobuf::RepeatedField<std::uint32_t>& size) {
    return fmt::format("{} x {} x {}", size.at(0), size.at(1), size.at(2));
}

void printHybrid(const proto::HybridManifest& hybrid) {
    fmt::print("source   {} of {}, values from {:.6g} to {:.6g}{}{}\n", sizeText(hybrid.source_size()),
               hybrid.scalar_type(), hybrid.value_min(), hybrid.value_max(),
               hybrid.value_unit().empty() ? "" : " ", hybrid.value_unit());
    fmt::print("volume   {}, {} bits, {}\n", sizeText(hybrid.low_size()), hybrid.value_bits(),
               hybrid.filter());
    fmt::print("errors   on {}", sizeText(hybrid.error_size()));
    if (hybrid.point_bytes() > 0) fmt::print(", as points of {} bytes", hybrid.point_bytes());
    fmt::print("{}\n\n", hybrid.residual() ? ", as residuals" : "");
    fmt::print("{:>6} {:>10} {:>12} {:>12} {:>12} {:>10} {:>9}\n", "step", "time", "threshold", "points",
               "residuals", "in bricks", "invalid");
    for (int i = 0; i < hybrid.steps_size(); ++i) {
        const auto& step = hybrid.steps(i);
        fmt::print("{:>6} {:>10.5g} {:>12.5g} {:>12} {:>12} {:>10} {:>9}\n", i, step.time(), step.threshold(),
                   step.points(), step.residual_samples(), step.residual_bricks(), step.invalid());
    }
}

void printText(const proto::Manifest& manifest) {
    fmt::print("title    {}\nkind     {}\nwriter   {}\n", manifest.title(), manifest.kind(),
               manifest.writer());
    if (manifest.has_particles()) printParticles(manifest);
    if (manifest.has_stipple()) printStipple(manifest);
    if (manifest.has_image()) printImage(manifest);
    if (manifest.has_hybrid()) {
        for (const auto& input : manifest.request().volume().inputs()) fmt::print("input    {}\n", input);
        printHybrid(manifest.hybrid());
    }
    if (manifest.kind() == "mesh") fmt::print("mesh     {}\n", manifest.request().mesh().input());
    if (manifest.has_mesh()) printMesh(manifest.mesh());
}

int run(const CommandLine& line, const std::string& directory) {
    const auto manifest = storage::readManifest(directory);
    if (!manifest.ok()) return fail(line, manifest.error());
    if (line.json) {
        fmt::print("{}", toJson(*manifest));
    } else {
        printText(*manifest);
    }
    return 0;
}

}  // namespace

void addInfoCommand(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("info", "Say what a dataset holds");
    const auto directory = std::make_shared<std::string>();
    command.option("DATASET", *directory, "NAME.mote").required();
    addOutputFlags(command, line);
    command.footer(
        "Examples:\n  mote-prep info beam.mote\n  mote-prep info beam.mote --json | jq .particles.axes");
    command.callback(
        [directory, &line] { line.command = [directory, &line] { return run(line, *directory); }; });
}

}  // namespace mote::prep
