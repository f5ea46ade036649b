#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs clang-tidy over sources of a build that is configured.

    tidy.py BUILD [--since COMMIT] [--jobs N] [FOLDER...]

All sources, those below the folders, or those that changed since a commit; of a changed header, the source of its name
or else the first that includes it. Exits 1 where clang-tidy finds anything.
"""
import argparse
import concurrent.futures
import functools
import json
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)
UNITED = re.compile(r'^#include "([^"]+)"', re.MULTILINE)
# clang-14 cannot compile Asio's awaitables with the standard library of GCC 12; whatever includes them is left out.
AWAITABLE = re.compile(r"asio/(awaitable|co_spawn|use_awaitable|detached|experimental/.*)\.hpp$|asio\.hpp$")
# What only GCC understands: its precompiled headers, and its own warnings as errors.
GCC_ONLY = [r" -include \S+cmake_pch\.hxx", r" -fpch-preprocess", r" -Winvalid-pch", r" -Werror\b",
            r" -fmerge-all-constants"]


def includes(path):
    """Our own files that one includes, and the names of all others."""
    text = path.read_text(encoding="utf-8", errors="replace")
    for own, foreign in INCLUDE.findall(text):
        beside = [ROOT / own, path.parent / own]
        yield next((file for file in beside if own and file.is_file()), None), own or foreign


@functools.cache
def reaches_awaitables(path):
    return any(AWAITABLE.search(name) or (own and own != path and reaches_awaitables(own))
               for own, name in includes(path))


def commands_of_each(entries):
    """A command for each source, where several are compiled as one (MOTE_UNITY), too."""
    for entry in entries:
        file = pathlib.Path(entry["file"])
        if file.parent.name != "Unity":
            yield entry
            continue
        for source in UNITED.findall(file.read_text()):
            command = entry["command"].replace(f"-c {file}", f"-c {source}")
            yield dict(entry, command=command, file=source)


def plain_commands(build):
    """The build's commands without what only GCC understands, in BUILD/tidy; the sources they compile."""
    def ours(entry):
        file = pathlib.Path(entry["file"])
        return file.is_relative_to(ROOT) and not file.is_relative_to(build)

    entries = json.loads((build / "compile_commands.json").read_text())
    commands = [entry for entry in commands_of_each(entries) if ours(entry)]
    for entry in commands:
        for pattern in GCC_ONLY:
            entry["command"] = re.sub(pattern, "", entry["command"])
    (build / "tidy").mkdir(exist_ok=True)
    (build / "tidy" / "compile_commands.json").write_text(json.dumps(commands, indent=1))
    return sorted({pathlib.Path(entry["file"]) for entry in commands})


def changed_since(commit):
    said = subprocess.run(["git", "diff", "--name-only", "--diff-filter=d", commit, "--", "*.h", "*.cpp"],
                          check=True, capture_output=True, text=True, cwd=ROOT)
    return [ROOT / line for line in said.stdout.splitlines()]


def source_of(header, sources):
    beside = header.with_suffix(".cpp")
    if beside in sources:
        return beside
    return next((source for source in sources if any(own == header for own, _ in includes(source))), None)


def chosen(arguments, sources):
    if arguments.since:
        known = set(sources)
        files = [file if file.suffix == ".cpp" else source_of(file, sources) for file in changed_since(arguments.since)]
        return sorted({file for file in files if file in known})
    folders = [(ROOT / folder).resolve() for folder in arguments.folders] or [ROOT]
    return [source for source in sources if any(source.is_relative_to(folder) for folder in folders)]


def check(build, source):
    said = subprocess.run(["clang-tidy", "--quiet", "-p", build / "tidy", source], capture_output=True, text=True)
    # On stderr it counts what it left out.
    return said.returncode, said.stdout + (said.stderr if said.returncode and not said.stdout else "")


def main():
    parser = argparse.ArgumentParser(usage=__doc__, add_help=False)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--since")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("folders", nargs="*")
    arguments = parser.parse_intermixed_args()
    if not shutil.which("clang-tidy"):
        print("tidy.py: there is no clang-tidy", file=sys.stderr)
        return 2
    build = arguments.build.resolve()
    wanted = chosen(arguments, plain_commands(build))
    sources = [source for source in wanted if not reaches_awaitables(source)]
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for source, (code, text) in zip(sources, pool.map(lambda source: check(build, source), sources)):
            if code:
                failed += 1
                print(f"{source.relative_to(ROOT)}:\n{text}", flush=True)
    left = f", {len(wanted) - len(sources)} left out" if len(wanted) > len(sources) else ""
    print(f"clang-tidy: {len(sources)} sources{left}, {failed} with findings")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
