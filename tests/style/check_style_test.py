#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The style check must see each kind of violation, and nothing in a tree that keeps the rules."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

import check_style

GOOD_HEADER = """// SPDX-License-Identifier: GPL-3.0-or-later
//
// Thing: a thing. A value.
#pragma once

#include <vector>
"""
GOOD_SOURCE = "// SPDX-License-Identifier: GPL-3.0-or-later\n"


def wrong(path, text):
    return list(check_style.check_file(path, text))


def including(path, include):
    return wrong(path, GOOD_SOURCE + f"#include {include}\n")


class Includes(unittest.TestCase):
    def test_what_the_table_forbids(self):
        for path, include in [
            ("client/view/a.cpp", '"storage/manifest.h"'),
            ("client/view/a.cpp", '"server/render/layers/scene.h"'),
            ("client/frames/a.cpp", "<hdf5.h>"),
            ("client/frames/a.cpp", "<openvdb/openvdb.h>"),
            ("client/frames/a.cpp", "<CGAL/Point_3.h>"),
            ("client/frames/a.cpp", "<mpi.h>"),
            ("client/frames/a.cpp", "<CLI/CLI.hpp>"),
            ("storage/a.cpp", '"protocol/cli/command.h"'),
            ("storage/a.cpp", '"protocol/wire/frame.h"'),
            ("storage/a.cpp", '"preprocess/progress.h"'),
            ("storage/a.cpp", '"server/render/layers/scene.h"'),
            ("preprocess/particles/a.cpp", '"server/jobs/job_queue.h"'),
            ("preprocess/particles/a.cpp", '"protocol/wire/frame.h"'),
            ("server/jobs/a.cpp", '"preprocess/progress.h"'),
            ("server/session/a.cpp", '"client/shared/client.h"'),
            ("server/render/cpu/a.cpp", '"server/render/layers/scene.h"'),
            ("server/render/egl/a.cpp", '"server/render/cpu/composite/packet.h"'),
            ("server/render/plan/a.cpp", '"server/render/layers/scene.h"'),
            ("server/data/a.cpp", '"server/frames/view_task.h"'),
            ("server/render/a.cpp", '"protocol/wire/frame.h"'),
            ("server/render/a.cpp", '"server/session/session.h"'),
            ("server/render/egl/a.cpp", "<asio/ip/tcp.hpp>"),
            ("server/render/a.cpp", "<sys/socket.h>"),
            ("server/encode/a.cpp", "<asio.hpp>"),
            ("protocol/scene/a.cpp", "<asio/post.hpp>"),
            ("protocol/scene/a.cpp", '"protocol/wire/frame.h"'),
            ("protocol/wire/a.cpp", '"server/session/session.h"'),
            ("storage/a.cpp", "<asio/post.hpp>"),
            ("server/session/a.cpp", '"tests/support/memory_step.h"'),
            ("server/session/a.cpp", '"session.h"'),
            ("server/session/a.cpp", "<storage/manifest.h>"),
        ]:
            with self.subTest(path=path, include=include):
                self.assertEqual([line for line, _ in including(path, include)], [2])

    def test_what_the_table_allows(self):
        for path, include in [
            ("client/view/a.cpp", '"protocol/wire/frame.h"'),
            ("client/view/a.cpp", "<asio/post.hpp>"),
            ("storage/a.cpp", '"protocol/base/error.h"'),
            ("storage/a.cpp", '"protocol/mote.pb.h"'),
            ("storage/a.cpp", "<hdf5.h>"),
            ("preprocess/particles/a.cpp", '"storage/publish.h"'),
            ("server/session/a.cpp", '"protocol/wire/frame.h"'),
            ("server/jobs/a.cpp", "<asio/post.hpp>"),
            ("server/render/a.cpp", '"storage/particles/particle_step.h"'),
            ("protocol/wire/a.cpp", "<asio/post.hpp>"),
            ("tests/unit/jobs/a.cpp", '"server/jobs/job_queue.h"'),
            ("tests/unit/jobs/a.cpp", "<asio/post.hpp>"),
            ("tests/unit/jobs/a.cpp", '"helper_beside_it.h"'),
        ]:
            with self.subTest(path=path, include=include):
                self.assertEqual(including(path, include), [])

    def test_an_include_is_seen_however_it_is_written(self):
        self.assertTrue(including("client/a.cpp", ' "storage/a.h"  // why not'))
        self.assertTrue(wrong("client/a.cpp", GOOD_SOURCE + '  #  include   "storage/a.h"\n'))
        self.assertFalse(wrong("client/a.cpp", GOOD_SOURCE + '// #include "storage/a.h"\n'))


class Files(unittest.TestCase):
    def test_a_good_header_is_good(self):
        self.assertEqual(wrong("storage/a.h", GOOD_HEADER), [])

    def test_the_licence(self):
        for path in ("storage/a.cpp", "storage/a.h", "server/render/egl/shaders/a.comp", "tests/a.py"):
            self.assertTrue(wrong(path, "// nothing\n" + GOOD_HEADER))
        self.assertTrue(wrong("storage/a.cpp", ""))
        script = "#!/bin/sh\n# SPDX-License-Identifier: GPL-3.0-or-later\n"
        self.assertEqual(wrong("tests/a.sh", script), [])

    def test_pragma_once_and_the_opening_paragraph(self):
        self.assertTrue(wrong("storage/a.h", GOOD_HEADER.replace("#pragma once", "#ifndef A")))
        self.assertTrue(wrong("storage/a.h", GOOD_HEADER.replace("// Thing: a thing. A value.\n", "")))

    def test_who_writes_to_stderr(self):
        for line in ('fmt::print(stderr, "x")', 'std::fprintf(stderr, "x")', 'std::cerr << "x"'):
            self.assertEqual(len(wrong("client/view/a.cpp", GOOD_SOURCE + line + "\n")), 1, line)
            self.assertEqual(wrong("tests/unit/a.cpp", GOOD_SOURCE + line + "\n"), [])

    def test_who_catches_that_memory_is_short(self):
        line = "} catch (const std::bad_alloc&) {\n"
        self.assertEqual(len(wrong("server/session/a.cpp", GOOD_SOURCE + line)), 1)
        self.assertEqual(wrong("storage/caught_error.cpp", GOOD_SOURCE + line), [])

    def test_the_length(self):
        lines = check_style.MOST_LINES - 1
        self.assertEqual(wrong("storage/a.cpp", GOOD_SOURCE + "int a;\n" * lines), [])
        self.assertTrue(wrong("storage/a.cpp", GOOD_SOURCE + "int a;\n" * (lines + 1)))


class Places(unittest.TestCase):
    """How sources are laid out."""

    def test_the_class_of_a_definition(self):
        for line, names in [
            ("void Cache::drop() {", {"Cache"}),
            ("Cache::Cache(int size)", {"Cache"}),
            ("Cache::~Cache() = default;", {"Cache"}),
            ("Result<Cache::Step> Cache::step(const Place& place) {", {"Cache"}),
            ("std::vector<std::pair<int, A::B>> Device::State::orderOf(", {"Device::State"}),
            ("const Part& Cache::part() const {", {"Cache"}),
            ("Cache& Cache::operator=(Cache&& other) noexcept {", {"Cache"}),
            ("template <class T> void Pool<T>::run() {", {"Pool"}),
            ("std::string nameOf(const Cache::Step& step) {", set()),
            ("const auto x = Cache::make(1);", set()),
            ("    Cache::drop();", set()),
            ("// Cache::drop() is called", set()),
            ("std::exit(1);", set()),
        ]:
            with self.subTest(line=line):
                self.assertEqual(check_style.classes_of(line + "\n"), names)

    def test_a_class_in_too_many_sources(self):
        sources = {f"server/a/{name}.cpp": f"void Cache::{name}() {{\n" for name in ("one", "two")}
        sources["server/b/three.cpp"] = "void Cache::three() {\n"  # another one, of another folder
        self.assertEqual(list(check_style.spread_classes(sources)), [])
        sources["server/a/three.cpp"] = "void Cache::three() {\n"
        self.assertEqual([folder for folder, _ in check_style.spread_classes(sources)], ["server/a"])

    def test_a_small_header_with_one_reader(self):
        own, reader = '#include "server/a/x.h"\n', {"server/b/y.cpp": '#include "server/a/x.h"\n'}
        small = {"server/a/x.h": GOOD_HEADER, "server/a/x.cpp": own, **reader}
        self.assertEqual([folder for folder, _ in check_style.small_headers(small)], ["server/a"])
        long = {**small, "server/a/x.h": GOOD_HEADER + "int a;\n" * check_style.SMALL_HEADER}
        self.assertEqual(list(check_style.small_headers(long)), [])
        read_twice = {**small, "tests/unit/a/x_test.cpp": own}
        self.assertEqual(list(check_style.small_headers(read_twice)), [])
        beside = {"tests/a/x.h": GOOD_HEADER, "tests/a/y.cpp": '#include "x.h"\n', "tests/b/y.cpp": '#include "x.h"\n'}
        self.assertEqual([folder for folder, _ in check_style.small_headers(beside)], ["tests/a"])

    def test_a_folder_with_too_many_sources(self):
        sources = {f"server/a/{number}.cpp": "" for number in range(check_style.MOST_FILES)}
        self.assertEqual(list(check_style.crowded_folders(sources)), [])
        sources["server/a/more.h"] = sources["server/b/other.cpp"] = ""
        self.assertEqual([folder for folder, _ in check_style.crowded_folders(sources)], ["server/a"])

    def test_the_lists_only_shrink(self):
        found = [("server/a", "x.h has one reader"), ("server/a", "y.h has one reader")]
        self.assertEqual(list(check_style.check_list("LIST", found, {"server/a": 2})), [])
        self.assertEqual(list(check_style.check_list("LIST", found, {"server/a": 3})), [])
        self.assertEqual(len(list(check_style.check_list("LIST", found, {"server/a": 1}))), 2)
        self.assertEqual(len(list(check_style.check_list("LIST", found, {}))), 2)
        obeys = list(check_style.check_list("LIST", [], {"server/a": 1}))
        self.assertEqual(obeys, ["server/a:1: keeps the rule of LIST in check_style.py: take it off that list"])


class Program(unittest.TestCase):
    def run_on(self, files):
        """The check of these files, as if no folder were on a list."""
        without = ("import sys, check_style as c; c.CROWDED = c.SPREAD_CLASSES = c.SMALL_HEADERS = {}; "
                   "sys.exit(c.main(sys.argv[1:]))")
        with tempfile.TemporaryDirectory() as folder:
            for path, text in files.items():
                file = pathlib.Path(folder) / path
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text, encoding="utf-8")
            program = pathlib.Path(check_style.__file__)
            return subprocess.run([sys.executable, "-B", "-c", without, folder], cwd=program.parent,
                                  capture_output=True, text=True, check=False)

    def test_a_good_tree_passes(self):
        result = self.run_on({"storage/a.h": GOOD_HEADER, "client/a.cpp": GOOD_SOURCE, "docs/a.md": "no licence"})
        self.assertEqual((result.returncode, result.stdout), (0, "2 files, 0 violations\n"))

    def test_a_violating_tree_fails_and_says_where(self):
        result = self.run_on({"storage/a.h": GOOD_HEADER, "client/b/a.cpp": GOOD_SOURCE + '#include "storage/a.h"\n'})
        self.assertEqual(result.returncode, 1)
        self.assertIn("client/b/a.cpp:2: may not include", result.stdout)
        self.assertIn("storage:1: storage/a.h has one reader, client/b/a.cpp", result.stdout)

    def test_an_empty_tree_is_no_success(self):
        self.assertEqual(self.run_on({}).returncode, 2)


if __name__ == "__main__":
    unittest.main()
