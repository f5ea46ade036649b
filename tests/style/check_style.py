#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks the tree against its own rules: who may include whom, what a source starts with, how long it may be, how many
files a folder, a class and a small header stand in; and that what the documents name in it is there.

    check_style.py ROOT

Prints one line a violation, "FILE:LINE: what is wrong", and exits 1 if there is any, 2 for wrong usage.
"""
import collections
import pathlib
import re
import sys

FOLDERS = ("protocol", "storage", "preprocess", "server", "client", "tests")
HEADERS = {".h"}
SOURCES = {".h", ".cpp"}
LICENSED = SOURCES | {".proto", ".glsl", ".comp", ".vert", ".frag", ".py", ".sh", ".ts", ".mjs"}
LICENCE = "SPDX-License-Identifier: GPL-3.0-or-later"
MOST_LINES = 800
# The one schema, and tables that nobody reads from top to bottom.
LONG_FILES = {"protocol/mote.proto", "protocol/scene/color_map_tables.h"}

# A folder holds at most so many sources, a class is defined in at most so many of them, and a header of fewer lines has
# more than one reader: a file, beside the source of its own name, that includes it.
MOST_FILES = 40
MOST_SOURCES = 2
SMALL_HEADER = 60
# What does not keep these rules yet: how often at most. These lists only shrink: a folder that keeps a rule is no longer
# named in its list.
CROWDED = {
    "protocol/scene": 17, "server/render/plan": 17, "tests/views": 11,
}
SPREAD_CLASSES = {
}
SMALL_HEADERS = {
    "protocol/scene/film": 2, "server/app": 1, "server/render": 1, "server/render/cpu": 3,
    "server/render/plan/matter": 1, "storage/files": 1, "tests/bench/device": 1, "tests/bench/hybrid": 1, "tests/bench/ink": 2, "tests/bench/link": 1,
    "tests/bench/memory": 2, "tests/bench/orbit": 2, "tests/bench/stipple_quality": 3, "tests/bench/stipple_tone": 2,
    "tests/bench/transport": 1, "tests/bench/video": 1, "tests/reference": 2, "tests/unit/readers": 1,
    "tests/unit/scene": 1, "tests/unit/synth": 1, "tests/views": 10,
}

# Who may include whom among our own folders: the longest prefix of a file's path holds. None: anything.
SCHEMA = "protocol/mote.pb.h"
BASE = "protocol/base/"
SCENE = "protocol/scene/"
QUANTITY = "protocol/quantity/"
CLI = "protocol/cli/"
DEVICE = ("server/render/plan/", "server/render/blank_picture.h", "server/render/calibration.h",
          "server/render/device.h", "server/render/color_finder.h", "storage/", BASE, SCENE, SCHEMA)
MAY_INCLUDE = {
    "protocol/": ("protocol/",),
    BASE: (BASE, SCHEMA),
    SCENE: (BASE, SCENE, QUANTITY, SCHEMA, "protocol/options.pb.h"),
    QUANTITY: (QUANTITY, BASE, SCENE, SCHEMA),
    "storage/": ("storage/", QUANTITY, BASE, SCENE, SCHEMA),
    CLI: (CLI, BASE, SCENE),
    "preprocess/": ("preprocess/", "storage/", CLI, QUANTITY, BASE, SCENE, SCHEMA),
    "server/": ("server/", "storage/", "protocol/"),
    "server/render/": ("server/render/", "storage/", BASE, SCENE, SCHEMA),
    # Devices know primitives, and primitives no layers.
    "server/render/cpu/": DEVICE + ("server/render/cpu/",),
    "server/render/egl/": DEVICE + ("server/render/egl/",),
    "server/render/ranks/": DEVICE + ("server/render/cpu/", "server/render/ranks/"),
    "server/render/plan/": ("server/render/plan/", "storage/", BASE, SCENE, SCHEMA),
    "server/render/ink/": ("server/render/ink/", "server/render/plan/", BASE, SCENE, SCHEMA),
    "server/render/layers/": ("server/render/layers/", "server/render/ink/", "server/render/plan/", "storage/", BASE, SCENE,
                              SCHEMA),
    "server/figures/": ("server/figures/", QUANTITY, BASE, SCENE, SCHEMA),
    "server/data/": ("server/data/", "server/log.h", "server/render/", "storage/", BASE, SCENE, SCHEMA),
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
    (NETWORK, "networking", ("protocol/base/", "protocol/scene/", "storage/", "preprocess/", "server/render/", "server/encode/", "server/data/")),
    (re.compile(r"(hdf5|H5|openvdb/|nanovdb/|CGAL/|mpi\.h|embree)"), "HDF5, OpenVDB, CGAL, MPI and Embree",
     ("protocol/", "client/")),
]

# Texts of others reach the terminal through complain() alone; who draws a bar, or ends a process, says only its own.
STDERR = re.compile(r"print\w*\(stderr\b|std::cerr")
MAY_USE_STDERR = ("protocol/base/complain.cpp", "protocol/base/error.cpp", "client/frames/frame_report.cpp",
                  "client/shared/jobs.cpp", "preprocess/console.cpp", "server/jobs/supervise/", "tests/")

# Memory that is short (docs/DECISIONS.md): only who answers a large request catches that, and programs of their own.
SHORTAGE = re.compile(r"catch \(const std::bad_alloc\b")
MAY_CATCH_SHORTAGE = ("storage/caught_error.cpp", "storage/dataset_writer.cpp", "storage/particles/step_tree.cpp",
                      "server/encode/encode.cpp", "server/figures/cairo_surface.cpp", "server/frames/picture_maker.cpp",
                      "server/jobs/supervise/", "preprocess/", "tests/")

NAMED = re.compile("`((?:" + "|".join(FOLDERS) + r"|deploy)/[\w/.-]+)`")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
# The class of a member function that is defined at the begin of a line.
MEMBER = re.compile(r"^(?:[^\s/#=(][^=(;]*[\s*&>])?((?:\w+(?:<[^<>()]*>)?::)+)(?:~?\w+|operator[^\w\s]+)\(")


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


def check_calls(path, lines):
    for pattern, allowed, what in (
        (STDERR, MAY_USE_STDERR, "stderr is written by complain() of protocol/base/complain.h alone"),
        (SHORTAGE, MAY_CATCH_SHORTAGE, "who is asked for something large catches by storage/caught_error.h, others not"),
    ):
        if not path.startswith(allowed):
            yield from ((number, what) for number, line in enumerate(lines, 1) if pattern.search(line))


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
        yield from check_calls(path, lines)


def classes_of(text):
    """The classes whose member functions a source defines."""
    names = {re.sub("<[^<>]*>", "", found[1])[:-2] for found in map(MEMBER.match, text.splitlines()) if found}
    return {name for name in names if name.split("::")[0] not in ("std", "mote")}


def spread_classes(sources):
    """(folder, sentence) of each class that stands in too many sources."""
    places = collections.defaultdict(list)
    for path, text in sources.items():
        if path.endswith(".cpp"):
            for name in classes_of(text):
                places[path.rpartition("/")[0], name].append(path.rpartition("/")[2])
    for (folder, name), files in sorted(places.items()):
        if len(files) > MOST_SOURCES:
            yield folder, f"{name} is defined in {', '.join(files)}: at most {MOST_SOURCES} sources"


def small_headers(sources):
    """(folder, sentence) of each small header that one file reads."""
    readers = collections.defaultdict(set)
    for path, text in sources.items():
        for found in filter(None, map(INCLUDE.match, text.splitlines())):
            name = found[2] if "/" in found[2] else f"{path.rpartition('/')[0]}/{found[2]}"
            if name.removesuffix(".h") + ".cpp" != path:
                readers[name].add(path)
    for path, text in sources.items():
        if path.endswith(".h") and len(text.splitlines()) < SMALL_HEADER and len(readers[path]) == 1:
            yield path.rpartition("/")[0], f"{path} has one reader, {readers[path].pop()}: put it there"


def crowded_folders(sources):
    """(folder, sentence) of each file that is too many in its folder."""
    count = collections.Counter(path.rpartition("/")[0] for path in sources)
    for folder, files in count.items():
        for number in range(MOST_FILES, files):
            yield folder, f"file {number + 1} of {files}: at most {MOST_FILES} in a folder"


def check_list(name, violations, allowed):
    """Violations of a rule that the folders of `allowed` need not keep yet; a folder in it must need to be."""
    folders = collections.defaultdict(list)
    for folder, what in violations:
        folders[folder].append(what)
    for folder in sorted({*folders, *allowed}):
        found, most = folders[folder], allowed.get(folder, 0)
        if len(found) > most:
            listed = f" (and {most} are allowed by {name})" if most else ""
            yield from (f"{folder}:1: {what}{listed}" for what in found)
        elif not found:
            yield f"{folder}:1: keeps the rule of {name} in check_style.py: take it off that list"


def check_places(sources):
    """Violations of how sources are laid out; `sources`: texts by path."""
    yield from check_list("CROWDED", crowded_folders(sources), CROWDED)
    yield from check_list("SPREAD_CLASSES", spread_classes(sources), SPREAD_CLASSES)
    yield from check_list("SMALL_HEADERS", small_headers(sources), SMALL_HEADERS)


def check_names(root, text):
    """Paths of the tree that a document names and that are not there; KIND stands for any."""
    for number, line in enumerate(text.splitlines(), 1):
        for name in NAMED.findall(line):
            if "KIND" not in name and not (root / name).exists() and not list(root.glob(name + ".*")):
                yield number, f"there is no `{name}`"


def check_tree(root):
    """Violations of the whole tree as "FILE:LINE: sentence", and the number of files that were looked at."""
    violations, sources = [], {}
    for folder in FOLDERS:
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in LICENSED or not file.is_file():
                continue
            path = file.relative_to(root).as_posix()
            sources[path] = text = file.read_text(encoding="utf-8", errors="replace")
            violations += [f"{path}:{line}: {what}" for line, what in check_file(path, text)]
    if sources:
        violations += check_places(sources)
    for file in sorted([*root.glob("*.md"), *(root / "docs").glob("*.md")]):
        text = file.read_text(encoding="utf-8")
        violations += [f"{file.relative_to(root)}:{line}: {what}" for line, what in check_names(root, text)]
    return violations, len(sources)


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
