// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cstdlib>
#include <memory>

#include "preprocess/auto/choice.h"
#include "preprocess/command_line.h"
#include "preprocess/look/look_at.h"
#include "preprocess/parallel/communicator.h"
#include "protocol/base/complain.h"
#include "protocol/base/utf8.h"
#include "protocol/scene/film/sized_script.h"

namespace mote::prep {
namespace {

namespace fs = std::filesystem;

constexpr const char* autoExamples = R"(Examples:
  mote-prep auto run.h5 --out plots/run.mote
  mote-prep auto chest.nrrd --out plots/chest.mote --json | jq '.chosen[]'
  mote-frames plots/run.view.json --spawn data=plots --out pictures

Chooses what INPUT is prepared as, how, and how it is drawn, and gives the reason for each choice in one line. Beside
NAME.mote it writes NAME.view.json, a view of it for mote-frames and mote-view, in which the folder is the root "data".
A part of a volume is tried in several forms, and the whole takes the one that is best in error and size together. A
photograph also gets NAME-dots.mote, the plane of dots that it is drawn with. To choose something else, use the
command of its kind: particles, volume, mesh or image.)";

struct AutoArguments {
    std::string input, output, title;
    int progressDescriptor = -1;
    JobResources resources;
};

/// The folder's part of "DIR/NAME.mote" and NAME.
struct OutputName {
    fs::path folder;
    std::string name;

    fs::path beside(std::string_view ending) const { return folder / (name + std::string(ending)); }
};

Result<OutputName> outputName(const std::string& output) {
    const fs::path path(output);
    if (path.extension() != ".mote" || path.stem().empty()) return invalid("--out", "is not DIR/NAME.mote");
    return OutputName{path.parent_path(), path.stem().string()};
}

proto::Script viewOf(const AutoChoice& choice, const OutputName& output) {
    proto::Script script;
    auto& view = *script.add_views();
    view.set_width(1280);
    view.set_height(720);
    auto& layer = *view.add_layers();
    const auto named = [&](std::string_view ending) { return fmt::format("data/{}{}", output.name, ending); };
    layer.set_dataset(named(choice.request.has_image() ? "-dots" : ""));
    if (choice.request.has_particles()) layer.mutable_particles();
    if (choice.request.has_volume()) layer.mutable_hybrid();
    if (choice.request.has_mesh()) layer.mutable_mesh();
    if (!choice.request.has_image()) return annotatedScript(std::move(script));
    layer.mutable_stipple()->set_image(named(""));  // nothing lies over a photograph
    return script;
}

JsonObject said(const AutoChoice& choice, const fs::path& view) {
    std::vector<JsonObject> chosen;
    for (const Reason& reason : choice.reasons)
        chosen.push_back(
            JsonObject().add("what", reason.what).add("value", reason.value).add("why", reason.why));
    return JsonObject().add("view", view.string()).add("chosen", chosen);
}

Result<AutoChoice> choose(const CommandLine& line, const AutoArguments& options) {
    ConsoleProgress progress(line.signal, {line.quiet, -1});
    LookOptions looking;
    looking.memory = options.resources.memory;
    MOTE_ASSIGN_OR_RETURN(const auto look, lookAt(options.input, looking, progress));
    MOTE_ASSIGN_OR_RETURN(auto choice,
                          chooseAutomatically(look, options.output, options.resources, progress));
    for (const Reason& reason : choice.reasons) {
        const auto text = fmt::format("{}: {} ({})", reason.what, reason.value, reason.why);
        if (!line.json) progress.note(toTerminalText(text));
    }
    return choice;
}

Result<DraftFile> beginView(const OutputName& output) {
    for (const char* const ending : {".mote", "-dots.mote", ".view.json"})
        MOTE_RETURN_IF_ERROR(mustNotExist(output.beside(ending)));
    if (startedByMpi())
        return unsupported("auto", "runs in one process; mote-prep particles and volume run under MPI");
    return DraftFile::create(output.beside(".view.json"));
}

/// The plane of dots, which the object of --json does not tell of.
int makeDots(const CommandLine& line, const AutoChoice& choice, const OutputName& output,
             const JobResources& resources) {
    if (!choice.dots.has_stipple()) return 0;
    auto dots = choice.dots;
    dots.set_output(output.beside("-dots.mote").string());
    const CommandLine text{line.signal, false, line.quiet || line.json};
    return runAndPrint(text, dots, {}, resources);
}

/// Says that there is a view, and what draws it.
void sayView(const OutputName& output) {
    const auto view = toTerminalText(output.beside(".view.json").string());
    const auto folder = output.folder.empty() ? std::string(".") : toTerminalText(output.folder.string());
    fmt::print("{0}: a view of it, drawn by mote-frames {0} --spawn data={1} --out pictures\n", view, folder);
}

int runAuto(const CommandLine& line, const AutoArguments& options) {
    const auto output = outputName(options.output);
    if (!output.ok()) return fail(line, output.error());
    const auto progress = checkProgressDescriptor(options.progressDescriptor);
    if (!progress.ok()) return fail(line, progress.error());
    auto view = beginView(*output);
    if (!view.ok()) return fail(line, view.error());
    auto choice = choose(line, options);
    if (!choice.ok()) return fail(line, choice.error());
    choice->request.set_output(options.output);
    choice->request.set_title(options.title);
    if (const int status = makeDots(line, *choice, *output, options.resources)) return status;
    const int status =
        runAndPrint(line, choice->request, {}, options.resources, {options.progressDescriptor, {}, {}},
                    said(*choice, output->beside(".view.json")));
    if (status != 0) return status;
    const Status written = writeScript(viewOf(*choice, *output), *view);
    if (!written.ok()) return fail(line, written.error());
    if (!line.json && !line.quiet) sayView(*output);
    return 0;
}

}  // namespace

void addAutoCommand(const cli::Command& program, CommandLine& line) {
    const auto command = program.subcommand("auto", "Choose how a file is prepared and drawn, and say why");
    const auto options = std::make_shared<AutoArguments>();
    command.option("INPUT", options->input, "A file, a folder, or a name with %T").required();
    command.option("--out", options->output, "The dataset to make, which must not exist")
        .required()
        .valueName("DIR/NAME.mote");
    command.option("--title", options->title, "Name shown by viewers").valueName("TEXT");
    addProgressOption(command, options->progressDescriptor);
    addResourceOptions(command, options->resources);
    addOutputFlags(command, line);
    command.footer(autoExamples);
    command.callback(
        [options, &line] { line.command = [options, &line] { return runAuto(line, *options); }; });
}

}  // namespace mote::prep
