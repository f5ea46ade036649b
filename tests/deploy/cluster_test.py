#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The recipes for clusters: Slurm's scripts hand on every argument as it is, and give what Slurm gives; the templates of
Open OnDemand are scripts that a shell understands.

    cluster_test.py DEPLOY
"""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

DEPLOY = pathlib.Path(sys.argv.pop(1)).resolve()
# Stands for srun, and says how it was called.
SRUN = """#!/usr/bin/env python3
import json, sys
print(json.dumps(sys.argv[1:]))
"""
AWKWARD = ["--root", "data=/a b/$(touch side-effect)", "'\"\\", "-x", "#SBATCH --nodes=9", "line\nline"]


class Slurm(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        srun = self.folder / "srun"
        srun.write_text(SRUN, encoding="utf-8")
        srun.chmod(0o755)

    def call(self, script, *arguments):
        environment = {"PATH": f"{self.folder}:{os.environ['PATH']}", "HOME": str(self.folder), "SLURM_JOB_ID": "7",
                       "SLURM_CPUS_PER_TASK": "16", "SLURM_MEM_PER_NODE": "10240", "SLURM_NTASKS": "2"}
        done = subprocess.run(["bash", DEPLOY / "slurm" / script, *arguments], capture_output=True, text=True,
                              env=environment, cwd=self.folder)
        return done.returncode, done.stdout

    def test_the_server(self):
        code, said = self.call("mote-server.sbatch", *AWKWARD)
        self.assertEqual(code, 0)
        words = json.loads(said.splitlines()[-1])
        state = f"{self.folder}/.local/state/mote-7"
        self.assertEqual(words, ["--mpi=pmix", "--cpus-per-task=16", "--kill-on-bad-exit=1", "mote-server", *AWKWARD,
                                 "--memory", "9216M", "--state", state, "--connection", f"{state}/connection.json"])
        self.assertEqual(os.stat(state).st_mode & 0o777, 0o700)
        self.assertFalse((self.folder / "side-effect").exists())

    def test_a_job(self):
        code, said = self.call("mote-prep.sbatch", *AWKWARD)
        self.assertEqual(code, 0)
        self.assertEqual(json.loads(said.splitlines()[-1]),
                         ["--mpi=pmix", "--cpus-per-task=16", "mote-prep", "particles", *AWKWARD, "--threads", "16",
                          "--memory", "9216M", "--quiet"])

    def test_without_arguments_they_say_how(self):
        for script in ("mote-server.sbatch", "mote-prep.sbatch"):
            self.assertEqual(self.call(script)[0], 2)


class OnDemand(unittest.TestCase):
    def test_templates_are_scripts(self):
        templates = sorted((DEPLOY / "ondemand" / "template").iterdir())
        self.assertEqual([path.name for path in templates], ["after.sh.erb", "before.sh.erb", "script.sh.erb"])
        for path in templates:
            done = subprocess.run(["bash", "-n", path], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""), path)

    def test_what_the_view_shows_is_told_to_it(self):
        """Open OnDemand hands a view host, port, password and what conn_params names."""
        view = (DEPLOY / "ondemand" / "view.html.erb").read_text(encoding="utf-8")
        submit = (DEPLOY / "ondemand" / "submit.yml.erb").read_text(encoding="utf-8")
        before = (DEPLOY / "ondemand" / "template" / "before.sh.erb").read_text(encoding="utf-8")
        told = set(re.findall(r"^    - (\w+)$", submit, re.MULTILINE))
        for name in set(re.findall(r"<%= (\w+) %>", view)) - {"host", "port", "password"}:
            self.assertIn(name, told)
            self.assertIn(f"export {name}=", before)


if __name__ == "__main__":
    unittest.main()
