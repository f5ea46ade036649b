// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <system_error>

#include "preprocess/command_line.h"
#include "preprocess/look/silent_notes.h"
#include "preprocess/parallel/communicator.h"
#include "preprocess/readers/format_detection.h"
#include "preprocess/readers/joined_source.h"
#include "protocol/quantity/quantity.h"
#include "protocol/scene/space/length_unit.h"
#include "storage/manifest.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

constexpr const char* runExamples = R"(Examples:
  mote-prep run run.h5 --axes z,x,y --out plots/run
  mote-prep run diags/openpmd_%T.bp --axes x,px,pz --species electrons,ions --out plots/lwfa
  mote-prep run lwfa.h5 --axes z,x,y --meshes E/z,rho --out plots/lwfa

Makes DIR/NAME-SPECIES.mote for every species, DIR/NAME-MESH.mote for the meshes that are named, and
DIR/NAME.view.json, which shows them together where they are: the first species in its plot's bounds, all others in
the same units beside it. In the view, the folder is the root "data". Meshes need the axes x, y and z, in any order.)";

struct RunArguments {
    std::string axes, species, meshes, output;
    proto::ParticlesJob run;  ///< inputs, format and steps
    JobResources resources;
};

/// A dataset of the run.
struct RunPart {
    std::string name;  ///< of the species or mesh; "": the only species
    bool mesh = false;
    fs::path path = {};
    proto::Manifest manifest = {};
};

/// What of a name a file's name may have.
std::string fileWord(std::string_view name) {
    std::string word(name.empty() ? "particles" : name);
    const auto fits = [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-';
    };
    std::ranges::replace_if(
        word, [&](char c) { return !fits(c); }, '_');
    return word;
}

Result<std::vector<RunPart>> partsOf(const CommandLine& line, const RunArguments& options) {
    MOTE_ASSIGN_OR_RETURN(auto species, namesOfSpecies(options.species));
    if (options.species.empty()) {
        ConsoleProgress progress(line.signal, {line.quiet, -1});
        SilentNotes silent(progress);
        const std::vector<fs::path> inputs(options.run.inputs().begin(), options.run.inputs().end());
        MOTE_ASSIGN_OR_RETURN(species, runSpecies(options.run, inputs, silent));
        if (species.empty()) species.emplace_back();
    }
    std::vector<RunPart> parts;
    parts.reserve(species.size());
    for (const auto& name : species) parts.push_back({name, false});
    if (!options.meshes.empty()) {
        for (const auto& name : splitNames(options.meshes)) parts.push_back({name, true});
    }
    std::set<fs::path> paths;
    for (auto& part : parts) {
        part.path = options.output + "-" + fileWord(part.name) + storage::datasetSuffix;
        if (!paths.insert(part.path).second)
            return invalid("--out", part.path.string() + " would be made twice");
        MOTE_RETURN_IF_ERROR(mustNotExist(part.path));
    }
    return parts;
}

proto::JobRequest requestOf(const RunArguments& options, const RunPart& part) {
    proto::JobRequest request;
    request.set_output(part.path.string());
    request.set_title(fmt::format("{} {}", fs::path(options.output).filename().string(), part.name));
    if (part.mesh) {
        *request.mutable_volume()->mutable_inputs() = options.run.inputs();
        request.mutable_volume()->mutable_source()->set_field(part.name);
        return request;
    }
    *request.mutable_particles() = options.run;
    request.mutable_particles()->set_species(part.name);
    for (const auto& axis : splitNames(options.axes)) request.mutable_particles()->add_axes(axis);
    return request;
}

/// From a plot's or a mesh's own space to that of the first plot, row by row.
Result<std::array<double, 16>> placeOf(const RunPart& part, const proto::ParticlesManifest& first) {
    std::array<double, 16> place{};
    place[15] = 1.0;
    auto* row = place.data();
    for (int i = 0; i < 3; ++i, row += 4) {
        const auto& axis = first.axes(i);
        const double extent = axis.max() - axis.min();
        row[3] = -(axis.max() + axis.min()) / extent;
        if (!part.mesh) {
            const auto& own = part.manifest.particles().axes(i);
            row[i] = (own.max() - own.min()) / extent;
            row[3] += (own.max() + own.min()) / extent;
            continue;
        }
        const auto& unit = worldUnit(part.manifest);
        const auto metre = metresOf(unit);
        if (!metre)
            return unsupported(part.name, fmt::format("lies in \"{}\", which is no unit of length", unit));
        row[axis.name().front() - 'x'] = 2.0 * *metre / extent;
    }
    return place;
}

/// The first iteration in which all species have particles, as each one's step; the first where there is
/// none.
void setSteps(std::vector<RunPart>& parts, proto::View& view) {
    const auto stepOf = [](const RunPart& part, std::int64_t iteration) {
        const auto& steps = part.manifest.particles().steps();
        const auto found = std::ranges::find(steps, iteration, &proto::ParticleStepEntry::iteration);
        return found == steps.end() || found->particles() == 0 ? -1 : static_cast<int>(found - steps.begin());
    };
    for (const auto& candidate : parts.front().manifest.particles().steps()) {
        const auto has = [&](const RunPart& part) {
            return part.mesh || stepOf(part, candidate.iteration()) >= 0;
        };
        if (!std::ranges::all_of(parts, has)) continue;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            auto& layer = *view.mutable_layers(static_cast<int>(i));
            if (!parts[i].mesh)
                layer.set_step(static_cast<std::uint32_t>(stepOf(parts[i], candidate.iteration())));
            const auto& steps = parts[i].manifest.hybrid().steps();
            const auto same = std::ranges::find(steps, candidate.time(), &proto::HybridStepEntry::time);
            if (parts[i].mesh && same != steps.end())
                layer.set_step(static_cast<std::uint32_t>(same - steps.begin()));
        }
        return;
    }
}

/// Species are told apart by their colours; the first has those of any plot.
void setColors(std::size_t place, proto::ParticlesStyle& style) {
    struct Colors {
        const char* map;
        std::array<double, 3> points;
    };
    constexpr std::array<Colors, 3> others{
        {{"viridis", {0.35, 0.8, 0.9}}, {"plasma", {0.95, 0.45, 0.75}}, {"cividis", {0.75, 0.9, 0.45}}}};
    if (place == 0) return;
    const auto& colors = others[(place - 1) % others.size()];
    style.mutable_volume()->set_color_map(colors.map);
    style.mutable_points()->mutable_color()->Add(colors.points.begin(), colors.points.end());
}

Result<proto::Script> viewOfRun(std::vector<RunPart>& parts) {
    proto::Script script;
    auto& view = *script.add_views();
    view.set_width(1280);
    view.set_height(720);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        auto& layer = *view.add_layers();
        layer.set_dataset("data/" + parts[i].path.stem().string());
        MOTE_ASSIGN_OR_RETURN(const auto place, placeOf(parts[i], parts.front().manifest.particles()));
        if (i > 0) layer.mutable_transform()->Add(place.begin(), place.end());
        if (parts[i].mesh) {
            layer.mutable_hybrid();
        } else {
            setColors(i, *layer.mutable_particles());
        }
    }
    setSteps(parts, view);
    return script;
}

Status checkRun(const RunArguments& options) {
    if (startedByMpi())
        return unsupported("run", "runs in one process; mote-prep particles and volume run under MPI");
    if (fs::path(options.output).filename().empty()) return invalid("--out", "is not DIR/NAME");
    auto axes = splitNames(options.axes);
    std::ranges::sort(axes);
    if (!options.meshes.empty() && axes != std::vector<std::string>{"x", "y", "z"})
        return invalid("--meshes", "a mesh lies along x, y and z, and the axes are " + options.axes);
    return success();
}

Status writeView(std::vector<RunPart>& parts, DraftFile& draft) {
    for (auto& part : parts) {
        MOTE_ASSIGN_OR_RETURN(part.manifest, storage::readManifest(storage::PathBeneath(part.path)));
    }
    MOTE_ASSIGN_OR_RETURN(const auto script, viewOfRun(parts));
    return writeScript(script, draft);
}

void say(const CommandLine& line, const std::vector<RunPart>& parts, const fs::path& view) {
    if (line.quiet && !line.json) return;
    std::vector<JsonObject> made;
    made.reserve(parts.size());
    for (const auto& part : parts)
        made.push_back(JsonObject()
                           .add("kind", part.mesh ? "hybrid" : "particles")
                           .add("name", part.name)
                           .add("output", part.path.string()));
    if (line.json) {
        fmt::print("{}\n", JsonObject().add("view", view.string()).add("datasets", made).text());
    } else {
        fmt::print("{}: {} dataset{} together\n", view.string(), parts.size(), parts.size() == 1 ? "" : "s");
    }
}

int runRun(const CommandLine& line, const RunArguments& options) {
    const Status fits = checkRun(options);
    if (!fits.ok()) return fail(line, fits.error());
    const fs::path viewPath = options.output + ".view.json";
    auto draft = DraftFile::create(viewPath);
    if (!draft.ok()) return fail(line, draft.error());
    auto parts = partsOf(line, options);
    if (!parts.ok()) return fail(line, parts.error());
    const CommandLine each{line.signal, false, line.quiet || line.json};
    int status = 0;
    std::size_t made = 0;
    while (status == 0 && made < parts->size()) {
        status = runAndPrint(each, requestOf(options, (*parts)[made]), {}, options.resources);
        if (status == 0) ++made;
    }
    if (status == 0) {
        const Status written = writeView(*parts, *draft);
        if (written.ok()) {
            say(line, *parts, viewPath);
            return 0;
        }
        status = fail(line, written.error());
    }
    // All of it or nothing: what was made before was made by us.
    std::error_code ignored;
    for (std::size_t i = 0; i < made; ++i) fs::remove_all((*parts)[i].path, ignored);
    return status;
}

}  // namespace

void addRunCommand(const cli::Command& program, CommandLine& line) {
    const auto command =
        program.subcommand("run", "Make plots of all species of a run, and a view of them together");
    const auto options = std::make_shared<RunArguments>();
    fieldOption(command, options->run, "inputs", "INPUT", "The files of one run, or a folder of them")
        .required();
    command.option("--axes", options->axes, "Three axes").required().valueName("A,B,C");
    command.option("--species", options->species, "Only these; default: all").valueName("NAME,...");
    command.option("--meshes", options->meshes, "Meshes that are shown too: mote-prep look names them")
        .valueName("NAME,...");
    fieldOption(command, options->run, "steps").valueName("FIRST:LAST:STRIDE");
    command.option("--out", options->output, "What the datasets' names begin with; none of them may exist")
        .required()
        .valueName("DIR/NAME");
    addResourceOptions(command, options->resources);
    addOutputFlags(command, line);
    command.footer(runExamples);
    command.callback(
        [options, &line] { line.command = [options, &line] { return runRun(line, *options); }; });
}

}  // namespace mote::prep
