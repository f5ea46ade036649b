// SPDX-License-Identifier: GPL-3.0-or-later
//
// The kinds of jobs: what mote-prep must know of each, said once beside its subcommand, command_KIND.cpp.
// Which files a request names, and what must hold of it besides, stands in protocol/scene/job_request.h, for
// servers too. Constants; one thread.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "preprocess/command_line.h"
#include "preprocess/job.h"
#include "protocol/base/error.h"
#include "protocol/mote.pb.h"

namespace mote::prep {

/// A job that is to run: its request, and the paths that the names in it stand for.
struct Job {
    const proto::JobRequest& request;
    const std::vector<std::filesystem::path>& inputs;
    const std::filesystem::path& output;
    const JobResources& resources;
    Progress& progress;
};

struct JobKind {
    proto::JobRequest::KindCase kind;
    bool together;  ///< whether several processes may do it together
    /// Adds the subcommand to the program.
    void (*addCommand)(const cli::Command& program, CommandLine& line);
    /// Makes the output. Returns its manifest, without a kind if it is no dataset. Errors: invalidArgument
    /// with the field's path, and the job's own.
    Result<proto::Manifest> (*run)(const Job& job);
};

extern const JobKind synthJob, particlesJob, imageJob, meshJob, stippleJob, volumeJob, exportJob;

/// All kinds, in the order in which help lists them.
inline constexpr std::array jobKinds{
#ifdef MOTE_HAVE_SYNTH
    &synthJob,
#endif
    &particlesJob, &imageJob, &meshJob, &stippleJob, &volumeJob, &exportJob};

}  // namespace mote::prep
