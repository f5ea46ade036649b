// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/rank_program.h"

#include <csignal>
#include <optional>

#include "server/data/data_memory.h"
#include "server/data/shared_file_steps.h"
#include "server/log.h"
#include "server/render/ranks/ranked_device.h"

namespace mote::server {
namespace {

constexpr int failed = 1;

/// The same on all ranks, as their command lines are. Errors: of the options.
Result<SharedFileSteps> stepsOf(const ServerSettings& settings) {
    MOTE_ASSIGN_OR_RETURN(auto roots, storage::Roots::parse(settings.roots));
    const auto memory = dataMemory(settings.memory);
    if (!memory.ok()) return memory.error().within("--memory");
    return SharedFileSteps(std::move(roots), *memory);
}

/// What keeps any rank from its work keeps all from theirs.
bool allReady(render::Ranks& ranks, const ServerSettings& settings, const Result<SharedFileSteps>& steps) {
    std::optional<Error> error;
    if (!steps.ok()) error = steps.error();
    if (settings.device == render::DeviceKind::egl) {
        error = Error{ErrorCode::unsupported, "--device", "several ranks draw with cpu alone"};
    }
    if (error) log::error("rank {}: {}", ranks.rank(), error->toString());
    return ranks.greatest(error ? 1 : 0) == 0;
}

}  // namespace

int runRank(render::Ranks& ranks, const ServerSettings& settings, const Serve& serve) {
    auto steps = stepsOf(settings);
    if (!allReady(ranks, settings, steps)) return failed;
    if (ranks.rank() != 0) {
        // They end when the first rank does, which a launcher's signal reaches too.
        for (const int number : {SIGTERM, SIGINT, SIGHUP}) std::signal(number, SIG_IGN);
        render::serveRanks(ranks, *steps, settings.threads);
        return 0;
    }
    const int code = serve(
        settings, [&] { return std::make_unique<render::RankedDevice>(ranks, *steps, settings.threads); });
    render::dismissRanks(ranks);
    return code;
}

}  // namespace mote::server
