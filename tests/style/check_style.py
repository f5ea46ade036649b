#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks the tree against its own rules: who may include whom, what a source starts with, how long it may be; and
that what the documents name in it is there.

    check_style.py ROOT

Prints one line a violation, "FILE:LINE: what is wrong", and exits 1 if there is any, 2 for wrong usage.
"""
import pathlib
import re
import sys

FOLDERS = ("protocol", "storage", "preprocess", "server", "client", "tests")
HEADERS = {".h"}
SOURCES = {".h", ".cpp"}
LICENSED = SOURCES | {".proto", ".glsl", ".comp", ".vert", ".frag", ".py", ".sh"}
LICENCE = "SPDX-License-Identifier: GPL-3.0-or-later"
MOST_LINES = 400
# The one schema, and tables that nobody reads from top to bottom.
LONG_FILES = {"protocol/mote.proto", "protocol/scene/color_map_tables.h"}

# Who may include whom among our own folders: the longest prefix of a file's path holds. None: anything.
SCHEMA = "protocol/mote.pb.h"
SCENE = "protocol/scene/"
QUANTITY = "protocol/quantity/"
CLI = "protocol/cli/"
DEVICE = ("server/render/plan/", "server/render/blank_picture.h", "server/render/calibration.h",
          "server/render/device.h", "server/render/color_finder.h", "storage/", SCENE, SCHEMA)
MAY_INCLUDE = {
    "protocol/": ("protocol/",),
    SCENE: (SCENE, QUANTITY, SCHEMA, "protocol/options.pb.h"),
    QUANTITY: (QUANTITY, SCENE, SCHEMA),
    "storage/": ("storage/", QUANTITY, SCENE, SCHEMA),
    CLI: (CLI, SCENE),
    "preprocess/": ("preprocess/", "storage/", CLI, QUANTITY, SCENE, SCHEMA),
    "server/": ("server/", "storage/", "protocol/"),
    "server/render/": ("server/render/", "storage/", SCENE, SCHEMA),
    # Devices know primitives, and primitives no layers.
    "server/render/cpu/": DEVICE + ("server/render/cpu/",),
    "server/render/egl/": DEVICE + ("server/render/egl/",),
    "server/render/ranks/": DEVICE + ("server/render/cpu/", "server/render/ranks/"),
    "server/render/plan/": ("server/render/plan/", "storage/", SCENE, SCHEMA),
    "server/render/ink/": ("server/render/ink/", "server/render/plan/", SCENE, SCHEMA),
    "server/render/layers/": ("server/render/layers/", "server/render/ink/", "server/render/plan/", "storage/", SCENE,
                              SCHEMA),
    "server/figures/": ("server/figures/", QUANTITY, SCENE, SCHEMA),
    "server/data/": ("server/data/", "server/log.h", "server/render/", "storage/", SCENE, SCHEMA),
    "server/frames/": ("server/frames/", "server/data/", "server/encode/", "server/figures/", "server/log.h", "server/render/",
                       "storage/", "protocol/"),
    "client/": ("client/", "protocol/"),
    "tests/": None,
}

# Foreign headers that only the given folders (and tests) may include.
NETWORK = re.compile(r"(asio(/|\.hpp)|sys/socket\.h|sys/un\.h|netinet/|arpa/|netdb\.h|openssl/)")
ONLY_IN = [
    (re.compile(r"(asio/|asio\.hpp)"), "Asio",
     ("protocol/wire/", "server/app/", "server/session/", "server/jobs/", "client/", "tests/")),
    (re.compile(r"CLI/"), "CLI11", ("protocol/cli/", "tests/")),
]
# Foreign headers that the given folders may not include.
NEVER_IN = [
    (NETWORK, "networking", ("protocol/scene/", "storage/", "preprocess/", "server/render/", "server/encode/", "server/data/")),
    (re.compile(r"(hdf5|H5|openvdb/|nanovdb/|CGAL/|mpi\.h|embree)"), "HDF5, OpenVDB, CGAL, MPI and Embree",
     ("protocol/", "client/")),
]

# Texts of others reach the terminal through complain() alone; who draws a bar, or ends a process, says only its own.
STDERR = re.compile(r"print\w*\(stderr\b|std::cerr")
MAY_USE_STDERR = ("protocol/scene/complain.cpp", "protocol/scene/error.cpp", "client/frames/progress_bar.cpp",
                  "client/shared/job_percentage.cpp", "preprocess/console.cpp", "server/jobs/supervise/", "tests/")

NAMED = re.compile("`((?:" + "|".join(FOLDERS) + r"|deploy)/[\w/.-]+)`")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def rule_for(path):
    """What MAY_INCLUDE says of a file."""
    matching = [prefix for prefix in MAY_INCLUDE if path.startswith(prefix)]
    return MAY_INCLUDE[max(matching, key=len)] if matching else None


def check_own_include(path, name):
    if not name.startswith(tuple(folder + "/" for folder in FOLDERS)):
        if path.startswith("tests/") and "/" not in name:
            return None  # a helper beside its only test
        return f'"{name}" is not named from the tree\'s root; foreign headers stand in angle brackets'
    allowed = rule_for(path)
    if allowed is not None and not name.startswith(allowed):
        return f'may not include "{name}", only {", ".join(allowed)}'
    return None


def check_foreign_include(path, name):
    if name.startswith(tuple(folder + "/" for folder in FOLDERS)):
        return f"<{name}> is ours and stands in quotation marks"
    for pattern, what, folders in ONLY_IN:
        if pattern.match(name) and not path.startswith(folders):
            return f"<{name}>: {what} may only be included in {', '.join(folders)}"
    for pattern, what, folders in NEVER_IN:
        if pattern.match(name) and path.startswith(folders):
            return f"<{name}>: {what} may not be included here"
    return None


def check_includes(path, lines):
    for number, line in enumerate(lines, 1):
        found = INCLUDE.match(line)
        if not found:
            continue
        check = check_own_include if found[1] == '"' else check_foreign_include
        wrong = check(path, found[2])
        if wrong:
            yield number, wrong


def check_stderr(path, lines):
    if path.startswith(MAY_USE_STDERR):
        return
    for number, line in enumerate(lines, 1):
        if STDERR.search(line):
            yield number, "stderr is written by complain() of protocol/scene/complain.h alone"


def check_header(path, lines):
    # A header that Highway compiles once for each target has its own guard.
    guard = "#pragma once" if not path.endswith("-inl.h") else "HWY_TARGET_TOGGLE"
    guarded = [number for number, line in enumerate(lines) if guard in line]
    if not guarded:
        yield 1, f"a header needs {guard}"
        return
    end = guarded[0]
    words = [line for line in lines[1:end] if line.startswith("//") and line.strip("/ \n")]
    if not words:
        yield 2, "a header opens with a paragraph that says what it is, who owns it and on which thread"


def check_file(path, text):
    """Violations of one file as (line, sentence); `path` is relative to the root, with slashes."""
    lines = text.splitlines()
    suffix = pathlib.PurePosixPath(path).suffix
    first = lines[1:2] if lines[:1] and lines[0].startswith("#!") else lines[:1]
    if suffix in LICENSED and not (first and LICENCE in first[0]):
        yield 1, f"the first line must say {LICENCE}"
    if suffix in LICENSED and len(lines) > MOST_LINES and path not in LONG_FILES:
        yield MOST_LINES + 1, f"{len(lines)} lines are more than {MOST_LINES}: split it"
    if suffix in HEADERS:
        yield from check_header(path, lines)
    if suffix in SOURCES:
        yield from check_includes(path, lines)
        yield from check_stderr(path, lines)


def check_names(root, text):
    """Paths of the tree that a document names and that are not there; KIND stands for any."""
    for number, line in enumerate(text.splitlines(), 1):
        for name in NAMED.findall(line):
            if "KIND" not in name and not (root / name).exists() and not list(root.glob(name + ".*")):
                yield number, f"there is no `{name}`"


def check_tree(root):
    """Violations of the whole tree as "FILE:LINE: sentence", and the number of files that were looked at."""
    violations, files = [], 0
    for folder in FOLDERS:
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in LICENSED or not file.is_file():
                continue
            files += 1
            path = file.relative_to(root).as_posix()
            text = file.read_text(encoding="utf-8", errors="replace")
            violations += [f"{path}:{line}: {what}" for line, what in check_file(path, text)]
    for file in sorted([*root.glob("*.md"), *(root / "docs").glob("*.md")]):
        text = file.read_text(encoding="utf-8")
        violations += [f"{file.relative_to(root)}:{line}: {what}" for line, what in check_names(root, text)]
    return violations, files


def main(arguments):
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    violations, files = check_tree(pathlib.Path(arguments[0]))
    for violation in violations:
        print(violation)
    if files == 0:
        print(f"{arguments[0]} holds no sources", file=sys.stderr)
        return 2
    print(f"{files} files, {len(violations)} violations")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
