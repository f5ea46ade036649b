// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/run_orders.h"

#include <unistd.h>

#include <algorithm>
#include <iterator>

#include "protocol/scene/job_request.h"
#include "server/jobs/job_environment.h"
#include "server/jobs/job_files.h"
#include "server/jobs/uploads.h"

namespace mote::server {
namespace {

// Of Open MPI. Its ranks are all on this machine, share memory without looking into each other's, and share
// the cores as the kernel likes.
constexpr const char* kLaunch[] = {"--oversubscribe",
                                   "--bind-to",
                                   "none",
                                   "--mca",
                                   "btl",
                                   "self,vader",
                                   "--mca",
                                   "btl_vader_single_copy_mechanism",
                                   "none",
                                   "--mca",
                                   "plm_rsh_agent",
                                   "/bin/false"};

constexpr int kPrepNiceness = 5;   // rendering comes first
constexpr int kFilmNiceness = 15;  // and films last

RunOrder orderOf(const JobSettings& settings, const std::filesystem::path& directory) {
    RunOrder order;
    order.directory = directory;
    order.memory = settings.memory;
    order.unconfined = settings.allowUnconfined;
    return order;
}

/// What Slurm does not give is not used: of one core nobody has said that it has more.
unsigned threadsOf(const JobSettings& settings) {
    return settings.runner == "slurm" ? std::max(settings.threads, 1U) : settings.threads;
}

/// mpirun, before the words of what it is to start. Its own files, and those of its parts, lie where TMPDIR
/// is. It asks no X server for GPUs (joinMpi() says why).
void launch(RunOrder& order, unsigned ranks) {
    order.launcher = true;
    order.scratch = order.directory / "mpi";
    order.program = {findProgram("env").string(),
                     "TMPDIR=" + order.scratch.string(),
                     "HWLOC_COMPONENTS=-gl",
                     findProgram("mpirun").string(),
                     "-n",
                     std::to_string(ranks)};
    order.program.insert(order.program.end(), std::begin(kLaunch), std::end(kLaunch));
    if (::geteuid() == 0) order.program.emplace_back("--allow-run-as-root");
}

RunOrder makeOrder(const JobSettings& settings, const storage::Roots& roots,
                   const std::filesystem::path& directory, unsigned ranks) {
    RunOrder order = orderOf(settings, directory);
    auto& words = order.program;
    if (ranks > 1) launch(order, ranks);
    words.insert(words.end(), {settings.prep.string(), "job", (directory / "request.json").string()});
    for (const auto& [name, folder] : roots.entries()) {
        words.insert(words.end(), {"--root", name + "=" + folder.string()});
        // Of the uploads its own only.
        const bool uploads = folder == settings.stateDirectory / Uploads::root;
        order.readable.push_back(uploads ? folder / directory.filename() : folder);
    }
    // mpirun hands on what ranks write to their output, and none of their other descriptors.
    if (ranks > 1) words.emplace_back("--quiet");
    words.insert(words.end(), {"--progress-fd", std::to_string(ranks > 1 ? 1 : progressDescriptor)});
    if (settings.memory != 0)
        words.insert(words.end(), {"--memory", std::to_string(settings.memory / ranks)});
    const auto threads = threadsOf(settings);
    if (threads != 0) words.insert(words.end(), {"--threads", std::to_string(threads)});
    order.cores = std::max(threads, 1U) * ranks;
    order.niceness = kPrepNiceness;
    return order;
}

}  // namespace

unsigned ranksOf(const JobSettings& settings, const proto::JobRequest& request) {
    const bool several = settings.runner != "local" && mayHaveRanks(request);
    return several ? std::max(settings.ranks, 1U) : 1;
}

RunOrder prepOrder(const JobSettings& settings, const storage::Roots& roots,
                   const std::filesystem::path& directory, unsigned ranks) {
    auto order = makeOrder(settings, roots, directory, ranks);
    order.program.insert(order.program.end(), {"--draft", directory.filename().string()});
    order.publishes = true;
    return order;
}

RunOrder exportOrder(const JobSettings& settings, const storage::Roots& roots,
                     const std::filesystem::path& directory) {
    auto order = makeOrder(settings, roots, directory, 1);
    const auto folder = artifactFolder(directory);
    order.program.insert(order.program.end(), {"--output", (folder / exportName).string()});
    order.writable = folder;
    return order;
}

RunOrder filmOrder(const JobSettings& settings, const std::filesystem::path& directory) {
    RunOrder order = orderOf(settings, directory);
    const auto connection = filmConnectionFile(settings.stateDirectory);
    order.program = {
        settings.frames.string(), "--job",         (directory / "request.json").string(), "--connect",
        connection.string(),      "--progress-fd", std::to_string(progressDescriptor)};
    order.readable = {connection.parent_path()};
    order.writable = artifactFolder(directory);
    order.niceness = kFilmNiceness;
    order.unixSockets = true;
    return order;
}

}  // namespace mote::server
