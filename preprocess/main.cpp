// SPDX-License-Identifier: GPL-3.0-or-later
//
// mote-prep: turns raw runs into datasets, and tells of them. A process of its own, so that a foreign file
// can hurt nobody else.
#include <fmt/format.h>
#include <malloc.h>

#include <new>

#include "preprocess/job_kinds.h"
#include "protocol/base/complain.h"
#include "storage/arrays/hdf5_layout.h"
#include "storage/storage_error.h"

namespace {

using namespace mote;

constexpr const char* examples = R"(Examples:
  mote-prep synth beam --particles 1000000 --steps 10 --seed 1 --out run.h5
  mote-prep particles run.h5 --axes x,px,y --out beam.mote
  mote-prep info beam.mote

Exit status: 0 on success, 2 for wrong usage, 75 if the disk is full or the like and a later try may succeed,
128 + N after signal N, else 1.)";

int runCommand(const prep::CommandLine& line) {
    try {
        return line.command();
    } catch (const storage::StorageError& error) {
        return prep::fail(line, error.error());
    } catch (const std::bad_alloc&) {
        return prep::fail(line,
                          {ErrorCode::resourceExhausted, "", "there is not enough memory for this job"});
    } catch (const std::exception& error) {
        return prep::fail(line, {ErrorCode::internal, "", error.what()});
    }
}

/// Buffers of some MiB come and go with every block of a file. Given back to the kernel each time, they come
/// back as pages that it clears first, which costs more than the work on them.
void keepFreedMemory() {
    ::mallopt(M_MMAP_THRESHOLD, 32 << 20);
    ::mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

int run(int argc, char** argv) {
    keepFreedMemory();
    storage::leaveHdf5Untidied();
    const prep::CancelSignal signal;
    prep::CommandLine line{signal};
    const cli::Program commandLine(
        "Prepares particle runs and volumes for viewing: makes, checks and exports datasets.", "mote-prep");
    const auto program = commandLine.command();
    program.requireOneSubcommand();
    program.footer(examples);
    for (const auto* kind : prep::jobKinds) kind->addCommand(program, line);
    prep::addAutoCommand(program, line);
    prep::addRunCommand(program, line);
    prep::addLookCommand(program, line);
    prep::addInfoCommand(program, line);
    prep::addVerifyCommand(program, line);
    prep::addJobCommand(program, line);
    if (const auto end = commandLine.parse(argc, argv)) return *end;
    return runCommand(line);
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& failure) {
        complainAtEnd("mote-prep", failure);  // even the words for an error take memory
        return 1;
    }
}
