// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/run_orders.h"

#include "server/jobs/film_files.h"

namespace mote::server {
namespace {

constexpr int kPrepNiceness = 5;   // rendering comes first
constexpr int kFilmNiceness = 15;  // and films last

RunOrder orderOf(const JobSettings& settings, const std::filesystem::path& directory) {
    RunOrder order;
    order.directory = directory;
    order.memory = settings.memory;
    return order;
}

}  // namespace

RunOrder prepOrder(const JobSettings& settings, const storage::Roots& roots,
                   const std::filesystem::path& directory, const std::filesystem::path& output) {
    RunOrder order = orderOf(settings, directory);
    auto& words = order.program;
    words = {settings.prep.string(), "job", (directory / "request.json").string()};
    for (const auto& [name, folder] : roots.entries()) {
        words.insert(words.end(), {"--root", name + "=" + folder.string()});
        order.readable.push_back(folder);
    }
    words.insert(words.end(), {"--progress-fd", std::to_string(progressDescriptor)});
    if (settings.memory != 0) words.insert(words.end(), {"--memory", std::to_string(settings.memory)});
    if (settings.threads != 0) words.insert(words.end(), {"--threads", std::to_string(settings.threads)});
    order.writable = output;
    order.niceness = kPrepNiceness;
    return order;
}

RunOrder filmOrder(const JobSettings& settings, const std::filesystem::path& directory) {
    RunOrder order = orderOf(settings, directory);
    const auto connection = filmConnectionFile(settings.stateDirectory);
    order.program = {
        settings.frames.string(), "--job",         (directory / "request.json").string(), "--connect",
        connection.string(),      "--progress-fd", std::to_string(progressDescriptor)};
    order.readable = {connection.parent_path()};
    order.writable = filmFolder(directory);
    order.niceness = kFilmNiceness;
    order.unixSockets = true;
    return order;
}

}  // namespace mote::server
