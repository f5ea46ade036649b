// SPDX-License-Identifier: GPL-3.0-or-later
//
// The command line of mote-prep: one function a subcommand, which adds it to the program and, where it was
// chosen, says how it went. What they share is owned by main.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "preprocess/console.h"
#include "preprocess/draft_file.h"
#include "preprocess/job.h"
#include "protocol/base/error.h"
#include "protocol/cli/command.h"
#include "protocol/mote.pb.h"
#include "storage/roots.h"

namespace mote::prep {

/// What all subcommands share. `command` is set by the one that was chosen; it returns the program's exit
/// status.
struct CommandLine {
    const CancelSignal& signal;
    bool json = false;
    bool quiet = false;
    std::function<int()> command = {};
};

/// The subcommands that make nothing; those of jobs are in job_kinds.h.
void addLookCommand(const cli::Command& program, CommandLine& line);
/// These make several things, and a view of them.
void addRunCommand(const cli::Command& program, CommandLine& line);
void addAutoCommand(const cli::Command& program, CommandLine& line);
void addInfoCommand(const cli::Command& program, CommandLine& line);
void addVerifyCommand(const cli::Command& program, CommandLine& line);
void addJobCommand(const cli::Command& program, CommandLine& line);

/// --json and --quiet.
void addOutputFlags(const cli::Command& command, CommandLine& line);
/// --progress-fd: an open descriptor, on which each change of progress is a line of JSON.
void addProgressOption(const cli::Command& command, int& descriptor);
/// Errors: invalidArgument, at the option.
Status checkProgressDescriptor(int descriptor);
/// --threads and --memory.
void addResourceOptions(const cli::Command& command, JobResources& resources);

/// An option that is a field of `message`, which outlives the parsing: "--error-grid" is error_grid, where it
/// has no other name. `field` may lie in messages within: "impact.mass". The schema says its help, its words
/// and its default (protocol/options.proto); `help` goes before that.
cli::Option fieldOption(const cli::Command& command, google::protobuf::Message& message,
                        const std::string& field, const std::string& name = {}, const std::string& help = {});
/// How a volume is to be read.
void addVolumeOptions(const cli::Command& command, proto::VolumeSourceOptions& source);

/// --up and --front.
void addOutlookOptions(const cli::Command& command, proto::JobRequest& request);

/// The job that a subcommand asks for: options fill in its request, and say what it may use.
struct AskedJob {
    proto::JobRequest request;
    JobResources resources;
};

/// --out and --title.
void addOutputOptions(const cli::Command& command, AskedJob& job);
/// Has the command run the job, once `complete` has been done to its request.
void runWhenChosen(const cli::Command& command, CommandLine& line, const std::shared_ptr<AskedJob>& job,
                   std::function<Status(proto::JobRequest&)> complete = {});
/// Adds all of these, and the resources and flags: for a command that makes a dataset.
void addDatasetOptions(const cli::Command& command, CommandLine& line, const std::shared_ptr<AskedJob>& job,
                       std::function<Status(proto::JobRequest&)> complete = {});

/// How a server has its jobs run.
struct ServedJob {
    int progressDescriptor = -1;   ///< JSON lines are written there; -1: nowhere
    std::filesystem::path output;  ///< of a request that has none
    std::string draft;             ///< not empty: OUTPUT is made as OUTPUT.partial-DRAFT/NAME, and left there
};

/// Runs a job with a progress bar, then prints what it made. `said`: what the object of --json begins with.
int runAndPrint(const CommandLine& line, const proto::JobRequest& request, const storage::Roots& roots,
                const JobResources& resources, const ServedJob& served = {}, const JsonObject& said = {});

/// Writes a script as JSON and publishes it. Errors: those of the draft, resourceExhausted.
Status writeScript(const proto::Script& script, DraftFile& draft);
/// Errors: alreadyExists.
Status mustNotExist(const std::filesystem::path& path);

/// Prints the error on stderr; 2 for wrong usage, 75 (EX_TEMPFAIL) if the error passes, 128 + signal where
/// one came, else 1.
int fail(const CommandLine& line, const Error& error);

}  // namespace mote::prep
