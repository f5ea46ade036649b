// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/app/server_option.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "server/app/http_listener.h"
#include "server/app/parse_size.h"

namespace mote::server {
namespace {

using Settings = ServerSettings;

const ServerOption table[] = {
    {"root", &Settings::roots, "NAME=DIR", "a folder of datasets and runs; may be repeated", true},
    {"state", &Settings::stateDirectory, "DIR",
     "the server's own folder, for jobs and the socket; created if absent", true},
    {"connection", &Settings::connectionFile, "FILE",
     "the file that tells clients where the server is, with the token (mode 0600)", true},
    {"followers", &Settings::followerFile, "FILE",
     "the same for people who may only look at datasets and follow sessions; default: nobody"},
    {"listen", &Settings::tcp, "ADDRESS",
     "unix (reached from elsewhere through ssh -L), or also tcp:HOST:PORT, with TLS; port 0: any; "
     "default unix"},
    {"device", &Settings::device, "KIND", "auto, egl or cpu: what renders; default auto"},
    {"memory", Size{&Settings::memory}, "SIZE",
     "what the server may use, and each job as well, for example 8G; default: half of the machine's memory "
     "for data, no limit for jobs"},
    {"threads", WholeNumber{&Settings::threads, 0, 4096}, "N",
     "threads of a job and of the device cpu; default all"},
    {"runner", Choice{&Settings::runner, {"local", "mpi", "slurm"}}, "local|mpi|slurm",
     "what runs jobs that make datasets and exports: this machine, mpirun, or sbatch; default local"},
    {"job-ranks", WholeNumber{&Settings::jobRanks, 1, 4096}, "N",
     "processes of a job, if its kind can use several, with mpi and slurm; default 1"},
    {"jobs", WholeNumber{&Settings::jobs, 1, 1000}, "N",
     "jobs that run at once, and one film besides; default 1"},
    {"jobs-waiting", WholeNumber{&Settings::jobsWaiting, 1, 100000}, "N",
     "jobs that may wait; one more is refused; default 1000"},
    {"jobs-kept", WholeNumber{&Settings::jobsKept, 1, 100000}, "N",
     "ended jobs that are kept; the oldest are forgotten, with the films and exports they made; default "
     "1000"},
    {"job-time", WholeNumber{&Settings::jobTime, 0, 30 * 86400}, "SECONDS",
     "time limit of a job or film; 0, the default: none"},
    {"allow-unconfined-jobs", &Settings::allowUnconfinedJobs, "",
     "run jobs even if the kernel cannot confine them (Landlock, seccomp)"},
    {"silence", Seconds{&Settings::silence, 86400}, "SECONDS",
     "a client's session ends if it does not answer for this long; 0: never; default 30"},
    {"idle", Seconds{&Settings::idle, 30 * 86400}, "SECONDS",
     "a client's session ends if it asks and waits for nothing for this long; 0: never; default 43200, "
     "twelve "
     "hours"},
    {"log", &Settings::logFile, "FILE", "where the log goes; default stderr"},
    {"log-format", Choice{&Settings::logFormat, {"text", "json"}}, "text|json",
     "lines for people, or one JSON object per line; default text"},
    {"log-size", Size{&Settings::logSize}, "SIZE", "size at which the log file is put aside; default 16M"},
    {"log-files", WholeNumber{&Settings::logFiles, 1, 100}, "N",
     "log files put aside that are kept; default 4"},
    {"metrics", HttpAddress{&Settings::metrics}, "ADDRESS",
     "where /metrics and /healthz are served over HTTP: unix:PATH or 127.0.0.1:PORT; default nowhere"},
};

/// Puts a text into the member that a row names.
struct Setter {
    const std::vector<std::string>& values;
    Settings& settings;
    const std::string& text() const { return values.front(); }

    Status operator()(std::vector<std::string> Settings::*list) const {
        settings.*list = values;
        return success();
    }
    Status operator()(std::filesystem::path Settings::*path) const {
        settings.*path = text();
        return success();
    }
    Status operator()(std::string Settings::*member) const {
        settings.*member = text();
        return success();
    }
    Status operator()(bool Settings::*flag) const {
        settings.*flag = text() == "true";
        return success();
    }
    Status operator()(render::DeviceKind Settings::*kind) const {
        MOTE_ASSIGN_OR_RETURN(settings.*kind, render::parseDeviceKind(text()));
        return success();
    }
    /// Where a server listens beside its Unix socket, if anywhere.
    Status operator()(std::optional<wire::Address> Settings::*address) const {
        (settings.*address).reset();
        if (text() == "unix") return success();
        if (!text().starts_with("tcp:")) {
            return Error{ErrorCode::invalidArgument, "",
                         fmt::format("\"{}\" is not unix or tcp:HOST:PORT", text())};
        }
        MOTE_ASSIGN_OR_RETURN(settings.*address, wire::parseAddress(text()));
        return success();
    }
    Status operator()(const Choice& choice) const {
        if (std::ranges::find(choice.words, text()) == choice.words.end()) {
            return Error{ErrorCode::invalidArgument, "",
                         fmt::format("\"{}\" is none of {}", text(), fmt::join(choice.words, ", "))};
        }
        settings.*choice.value = text();
        return success();
    }
    Status operator()(const HttpAddress& address) const {
        MOTE_RETURN_IF_ERROR(HttpListener::parse(text()));
        settings.*address.value = text();
        return success();
    }
    Status operator()(Size size) const {
        MOTE_ASSIGN_OR_RETURN(settings.*size.value, parseSize(text()));
        return success();
    }
    Status operator()(const WholeNumber& number) const {
        MOTE_ASSIGN_OR_RETURN(settings.*number.value, wholeNumber(number.least, number.greatest));
        return success();
    }
    Status operator()(const Seconds& seconds) const {
        MOTE_ASSIGN_OR_RETURN(const auto value, wholeNumber(0, seconds.greatest));
        settings.*seconds.value = std::chrono::seconds(value);
        return success();
    }

    Result<unsigned> wholeNumber(unsigned least, unsigned greatest) const {
        std::int64_t value = 0;
        const char* const end = text().data() + text().size();
        const auto [rest, code] = std::from_chars(text().data(), end, value);
        if (code != std::errc{} || rest != end || value < least || value > greatest) {
            return Error{ErrorCode::invalidArgument, "",
                         fmt::format("\"{}\" is no whole number of {} to {}", text(), least, greatest)};
        }
        return static_cast<unsigned>(value);
    }
};

}  // namespace

Status ServerOption::set(const std::vector<std::string>& values, ServerSettings& settings) const {
    if (values.empty()) return success();
    if (values.size() > 1 && !isList()) {
        return Error{ErrorCode::invalidArgument, "", "it is given twice"};
    }
    auto done = std::visit(Setter{values, settings}, target);
    if (done.ok()) return done;
    return Error{ErrorCode::invalidArgument, "", done.error().message};
}

std::span<const ServerOption> serverOptions() {
    return table;
}

const ServerOption* findOption(std::string_view name) {
    const auto* found = std::ranges::find(table, name, &ServerOption::name);
    return found == std::end(table) ? nullptr : found;
}

}  // namespace mote::server
