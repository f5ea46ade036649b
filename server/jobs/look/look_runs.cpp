// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/look/look_runs.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <utility>

#include "protocol/base/system_error.h"
#include "server/jobs/job_files.h"
#include "server/jobs/look/look_answer.h"
#include "server/jobs/state_directory.h"
#include "storage/files/dataset_file.h"

namespace mote::server {
namespace {

namespace fs = std::filesystem;

constexpr int lookNiceness = 5;            // rendering comes first
constexpr std::size_t longestWord = 4096;  // bytes of a client's, in a command line

/// What a reader whose answer is missing came to.
Error whyNothing(const std::string& name, const JobFiles::Outcome& outcome, const std::string& lastLine) {
    if (outcome.timedOut) {
        return {ErrorCode::resourceExhausted, name,
                fmt::format("looking at it took longer than {} s, and was ended", outcome.number)};
    }
    if (outcome.signalled && outcome.number == SIGXFSZ) {
        return {ErrorCode::resourceExhausted, name,
                fmt::format("what it holds takes more than {} MiB to be told", LookRuns::mostWritten >> 20)};
    }
    if (outcome.signalled) {
        return corrupt(name,
                       fmt::format("is damaged in a way that its reader does not survive (it was ended by "
                                   "signal {})",
                                   outcome.number));
    }
    return {ErrorCode::internal, name,
            lastLine.empty() ? "its reader ended without a word" : "cannot be looked at: " + lastLine};
}

std::string lastLineOf(const std::string& text) {
    const auto end = text.find_last_not_of('\n');
    if (end == std::string::npos) return {};
    const auto begin = text.rfind('\n', end);
    const auto at = begin == std::string::npos ? 0 : begin + 1;
    return plainText(std::string_view(text).substr(at, end + 1 - at), 300);
}

}  // namespace

LookRuns::LookRuns(asio::io_context& context, JobSettings settings, storage::Roots roots)
    : settings_(std::move(settings)),
      roots_(std::move(roots)),
      folder_(settings_.stateDirectory / "looks"),
      runner_(makeLocalRunner(context, settings_.supervisor)) {}

LookRuns::~LookRuns() {
    for (const auto& one : all_) {
        if (one.run) one.run->cancel();
    }
}

Status LookRuns::start() {
    std::error_code code;
    fs::remove_all(folder_, code);
    return makeOwnFolder(folder_);
}

std::size_t LookRuns::running() const {
    return static_cast<std::size_t>(std::ranges::count_if(all_, [](const One& one) { return one.begun; }));
}

void LookRuns::look(Ticket ticket, const proto::LookAtFile& wanted, Answered answered) {
    if (all_.size() >= mostAtOnce + mostWaiting) {
        return answered(
            Error{ErrorCode::resourceExhausted, wanted.input(),
                  fmt::format("{} files wait to be looked at; ask again in a moment", all_.size())});
    }
    One one{ticket, wanted, std::move(answered)};
    if (const auto ready = prepare(one); !ready.ok()) return one.answered(ready.error());
    all_.push_back(std::move(one));
    beginNext();
}

void LookRuns::cancel(Ticket ticket) {
    const auto place = std::ranges::find(all_, ticket, &One::ticket);
    if (place == all_.end()) return;
    place->answered = nullptr;
    if (!place->begun) {
        all_.erase(place);
    } else if (place->run) {
        place->run->cancel();
    }
}

/// Finds the file, and opens nothing: a pipe would never answer.
Status LookRuns::prepare(One& one) const {
    const auto& wanted = one.wanted;
    if (wanted.format().size() > longestWord)
        return invalid("format", "is longer than a format's name may be");
    if (wanted.map().size() > longestWord)
        return invalid("map", fmt::format("has more than {} bytes", longestWord));
    for (const auto& [field, text] :
         {std::pair("format", &wanted.format()), std::pair("map", &wanted.map())}) {
        if (text->find('\0') != std::string::npos) return invalid(field, "holds a zero byte");
    }
    MOTE_ASSIGN_OR_RETURN(one.path, roots_.resolveExisting(wanted.input()));
    struct stat status {};
    if (::lstat(one.path.c_str(), &status) != 0)
        return systemError(errno, wanted.input(), "cannot be looked up");
    if (!S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode))
        return invalid(wanted.input(), "is neither a file nor a folder");
    return success();
}

RunOrder LookRuns::orderOf(const One& one) const {
    RunOrder order;
    order.directory = one.directory;
    order.memory = settings_.memory == 0 ? mostMemory : std::min(settings_.memory, mostMemory);
    order.program = {settings_.prep.string(),     "look", "--json", "--quiet", "--confined", "--memory",
                     std::to_string(order.memory)};
    if (!one.wanted.format().empty()) order.program.push_back("--format=" + one.wanted.format());
    if (!one.wanted.map().empty()) order.program.push_back("--map=" + one.wanted.map());
    order.program.push_back(one.path.string());
    for (const auto& root : roots_.entries()) order.readable.push_back(root.folder);
    order.unconfined = settings_.allowUnconfined;
    order.niceness = lookNiceness;
    order.timeLimit = seconds;
    order.fileSize = mostWritten;
    return order;
}

void LookRuns::beginNext() {
    while (running() < mostAtOnce) {
        const auto place = std::ranges::find_if(all_, [](const One& one) { return !one.begun; });
        if (place == all_.end()) return;
        begin(place);
    }
}

void LookRuns::begin(Place place) {
    place->begun = true;
    place->directory = folder_ / fmt::format("{}", ++serial_);
    if (const auto made = JobFiles::makeScratch(place->directory); !made.ok())
        return finish(place, made.error());
    // A local runner answers before it returns.
    runner_->start(orderOf(*place), [&](Result<std::unique_ptr<Run>> started) {
        if (!started.ok()) return finish(place, started.error());
        place->run = *std::move(started);
        place->run->onEnd([this, place](const RunEnd&) { ended(place); });
        place->run->go();
    });
}

void LookRuns::ended(Place place) {
    finish(place, place->answered ? answerOf(*place) : Result<proto::Look>(wasCancelled()));
    beginNext();
}

void LookRuns::finish(Place place, Result<proto::Look> answer) {
    std::error_code code;
    fs::remove_all(place->directory, code);
    const auto answered = std::move(place->answered);
    all_.erase(place);
    if (answered) answered(std::move(answer));
}

Result<proto::Look> LookRuns::answerOf(const One& one) const {
    const auto& name = one.wanted.input();
    MOTE_ASSIGN_OR_RETURN(const auto outcome, JobFiles(one.directory).outcome());
    auto written = storage::readWhole(one.directory / "log", mostWritten);
    if (!written.ok()) return Error{written.error().code, name, "what was told of it cannot be read"};
    if (!outcome) return Error{ErrorCode::internal, name, "its reader was lost"};
    auto answer = lookAnswer(*written, one.path.string(), name);
    if (answer.ok() || (!outcome->signalled && !outcome->timedOut && outcome->number <= 1)) return answer;
    return whyNothing(name, *outcome, lastLineOf(*written));
}

}  // namespace mote::server
