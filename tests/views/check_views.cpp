// SPDX-License-Identifier: GPL-3.0-or-later
//
// check-views: holds generated views, or views in files, to what any legal view owes: see view_check.h. Views
// are checked in a process of its own, so that one that ends it is found, shrunk and kept. Exit status 1
// where the views are not as they must be.
#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iostream>
#include <optional>

#include "protocol/base/json.h"
#include "protocol/cli/command.h"
#include "tests/support/only_vectors.h"
#include "tests/views/check_worker.h"
#include "tests/views/shrinker.h"
#include "tests/views/view_generator.h"
#include "tests/views/view_report.h"

namespace mote::test {
namespace {

struct Run {
    std::uint64_t seed = 1, first = 0, count = 100, pixels = 768;
    std::string check = "difference", device = "cpu", vectors, keep, record;
    std::vector<std::string> files;
    double below = 45.0;  ///< dB, what is a failure that is told and kept
    int most = 1;         ///< steps of 255, likewise
    int questions = 1500;
    bool serve = false, quiet = false;
};

bool failed(const Run& run, const Verdict& verdict) {
    if (verdict.kind == Verdict::Kind::broken || verdict.kind == Verdict::Kind::dead) return true;
    if (verdict.kind == Verdict::Kind::undecided) return false;
    if (run.check == "bytes") return verdict.worst > run.most;
    return run.check != "survival" && verdict.psnr < run.below;
}

/// A view that is shrunk stays below 35 dB where it was, so that what is left has the same cause.
bool failsAlike(const Run& run, const Verdict& before, const Verdict& verdict) {
    if (verdict.kind != before.kind) return false;
    Run strict = run;
    if (before.psnr < 35.0) strict.below = 35.0;
    return failed(strict, verdict);
}

void writeView(const proto::View& view, const std::filesystem::path& path) {
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << toJson(view);
}

void keep(const Run& run, const std::string& name, const proto::View& view, const Verdict& verdict,
          ViewCheck& check) {
    const std::filesystem::path folder(run.keep);
    writeView(view, folder / (name + "-whole.json"));
    const auto small = shrunk(
        view, [&](const proto::View& smaller) { return failsAlike(run, verdict, check.check(smaller)); },
        run.questions);
    writeView(small, folder / (name + ".json"));
}

std::string told(const std::string& name, const Verdict& verdict) {
    const char* const end = verdict.kind == Verdict::Kind::dead     ? "DEAD "
                            : verdict.kind == Verdict::Kind::broken ? "BROKEN "
                                                                    : "";
    return fmt::format("{}: {}{:.2f} dB, worst {}, {:.1f}% in doubt, {} samples {}", name, end, verdict.psnr,
                       verdict.worst, 100.0 * verdict.doubtful, verdict.samples, verdict.text);
}

/// Of each view a hash of its pictures: what two builds draw alike has the same.
void record(const Run& run, const std::string& name, const Verdict& verdict) {
    if (run.record.empty()) return;
    std::ofstream(run.record, std::ios::app) << name << ' ' << verdict.pictures << '\n';
}

void examine(const Run& run, const std::string& name, const proto::View& view, ViewCheck& check,
             ViewReport& report) {
    const auto verdict = check.check(view);
    report.add(name, verdict);
    record(run, name, verdict);
    const bool fails = failed(run, verdict);
    if (fails || !run.quiet) std::cout << told(name, verdict) << std::endl;
    if (fails && !run.keep.empty()) keep(run, name, view, verdict, check);
}

int checkAll(const Run& run, ViewCheck& check) {
    ViewReport report(run.check);
    for (const auto& file : run.files) {
        proto::View view;
        const auto read = readJsonFile(file, view);
        if (!read.ok()) throw std::runtime_error(read.error().toString());
        examine(run, std::filesystem::path(file).stem().string(), view, check, report);
    }
    for (std::uint64_t i = 0; run.files.empty() && i < run.count; ++i) {
        const std::uint64_t number = run.first + i;
        examine(run, fmt::format("{}-{}-{}-{}", run.check, run.device, run.seed, number),
                generatedView(run.seed, number, {run.pixels}), check, report);
    }
    std::cout << report.toString();
    return report.good() ? 0 : 1;
}

int serve(const Run& run) {
    std::optional<OnlyVectors> only;
    if (!run.vectors.empty()) {
        const auto target = render::vectorsNamed(run.vectors);
        if (!target) throw std::invalid_argument("this processor has no vectors called " + run.vectors);
        only.emplace(*target);
    }
    serveChecks(*viewCheckOf(run.check, run.device));
    return 0;
}

void addOptions(const mote::cli::Command& app, Run& run) {
    app.option("--seed", run.seed, "of the series of views");
    app.option("--first", run.first, "number of the first view of the series");
    app.option("--count", run.count, "how many views");
    app.option("--pixels", run.pixels, "most pixels of a picture");
    app.option("--check", run.check, "difference, survival, bytes or dissolve");
    app.option("--device", run.device, "cpu, egl or ranks");
    app.option("--vectors", run.vectors, "the only ones that are used: avx-512, avx2, sse4, ssse3, scalar");
    app.option("--below", run.below, "dB: what is a failure of \"difference\" and \"dissolve\"");
    app.option("--most", run.most, "steps of 255: beyond is a failure of \"bytes\"");
    app.option("--keep", run.keep, "folder for views that fail, whole and shrunk");
    app.option("--record", run.record,
               "of \"survival\": file to which a line is added with a hash of each view's pictures");
    app.option("--questions", run.questions, "most pictures that are drawn to shrink a view");
    app.option("--view", run.files, "files with views, in place of generated ones");
    app.flag("--quiet", run.quiet, "tell of failures alone");
    app.flag("--serve", run.serve, "read views from stdin").hidden();
}

int run(const Run& run) {
    if (run.serve) return serve(run);
    signal(SIGPIPE, SIG_IGN);  // a worker that ended is found by what it does not answer
    std::vector<std::string> arguments{"--serve", "--check", run.check, "--device", run.device};
    if (!run.vectors.empty()) arguments.insert(arguments.end(), {"--vectors", run.vectors});
    CheckWorker worker(arguments);
    return checkAll(run, worker);
}

int runProgram(int argc, char** argv) {
    Run asked;
    const mote::cli::Program commandLine("Holds generated views to what any legal view owes", "check-views");
    const auto app = commandLine.command();
    addOptions(app, asked);
    if (const auto end = commandLine.parse(argc, argv)) return *end;
    return run(asked);
}

}  // namespace
}  // namespace mote::test

int main(int argc, char** argv) {
    try {
        return mote::test::runProgram(argc, argv);
    } catch (const std::exception& failure) {
        std::cerr << "check-views: " << failure.what() << '\n';
        return 2;
    }
}
