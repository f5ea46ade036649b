#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that deploy/tidy.py finds the sources of a build, also those that are compiled several as one.

    tidy_test.py DEPLOY
"""
import importlib.util
import json
import pathlib
import sys
import tempfile
import unittest


def load(deploy):
    spec = importlib.util.spec_from_file_location("tidy", deploy / "tidy.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Sources(unittest.TestCase):
    def test_sources_compiled_as_one_are_each_looked_at(self):
        root = tidy.ROOT
        alone, *united = [root / "storage" / name for name in ("hash.cpp", "verify.cpp", "manifest.cpp")]
        with tempfile.TemporaryDirectory() as folder:
            build = pathlib.Path(folder)
            unity = build / "storage" / "Unity" / "unity_0_cxx.cxx"
            unity.parent.mkdir(parents=True)
            unity.write_text("".join(f'#include "{source}"\n' for source in united))
            commands = [{"directory": folder, "file": str(file), "command": f"c++ -I{root} -Werror -o a.o -c {file}"}
                        for file in (alone, unity)]
            (build / "compile_commands.json").write_text(json.dumps(commands))
            self.assertEqual(tidy.plain_commands(build), sorted([alone, *united]))
            written = json.loads((build / "tidy" / "compile_commands.json").read_text())
        self.assertEqual({entry["file"]: entry["command"] for entry in written},
                         {str(source): f"c++ -I{root} -o a.o -c {source}" for source in (alone, *united)})


if __name__ == "__main__":
    tidy = load(pathlib.Path(sys.argv.pop(1)))
    unittest.main()
