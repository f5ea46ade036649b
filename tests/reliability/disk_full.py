#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Full disks: of outputs and of the server's state, at every so many bytes of room; and a limit of file sizes.

    disk_full.py [--build build/release] [--steps 12]

The disks are tmpfs in a mount namespace of the script's own, which ends with it; that takes root, or a kernel where
anybody may make one, and is left out with a sentence elsewhere. Whatever room there is: an error is one sentence, the
dataset that was there before is as it was, nothing unfinished is visible or left, no job that was told is lost, and the
server lives. Prints how often it was tried and what broke; exits 1 where anything did.
"""
import argparse
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import time

import own_server
from kill_prep_everywhere import digest

mote = own_server.mote

DISK = 4 << 20
PAGE = 4096
WITHIN = "MOTE_DISK_FULL_WITHIN"


def enter_namespace():
    """Goes on as a process of a mount namespace of its own; returns where there is none to be had."""
    if os.environ.get(WITHIN):
        return True
    ways = [["unshare", "--mount", "--propagation", "private"], ["unshare", "--user", "--map-root-user", "--mount"]]
    for way in ways:
        trial = f"set -e; d=$(mktemp -d); mount -t tmpfs -o size={DISK} none $d; umount $d; rmdir $d"
        done = subprocess.run([*way, "sh", "-c", trial], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        if done.returncode == 0:
            os.environ[WITHIN] = "1"
            os.execvp(way[0], [*way, sys.executable, *sys.argv])
    return False


def mount(folder):
    folder.mkdir(mode=0o700, exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={DISK},mode=0700", "none", folder], check=True)


def unmount(folder):
    # What jobs that live on still hold goes with them.
    subprocess.run(["umount", "--lazy", folder], check=True)


def leave(folder, room):
    """Fills a disk up to so many bytes of room."""
    ballast = folder / "ballast"
    ballast.unlink(missing_ok=True)
    free = os.statvfs(folder).f_bavail * os.statvfs(folder).f_frsize
    with open(ballast, "wb") as file:
        os.posix_fallocate(file.fileno(), 0, max(free - room, PAGE))


class Verdict:
    def __init__(self):
        self.tried = self.refused = self.broken = 0

    def add(self, name, wrongs, refused):
        self.tried += 1
        self.refused += refused
        self.broken += bool(wrongs)
        for wrong in wrongs:
            print(f"{name}: {wrong}", flush=True)


def is_sentence(text):
    return bool(text) and "\n" not in text


def wait(job):
    """Until it ends, or waits for a fault of the place."""
    end = time.monotonic() + 60
    while not job.finished and not job.waits_for and time.monotonic() < end:
        try:
            job.wait(timeout=0.5, progress=False)
        except mote.Error:
            pass


def submit(session, output):
    return session.prepare("data/run.h5", axes=["x", "px", "y"], output=f"data/{output}.mote")


def judge_output(build, here, job, before):
    data = here / "data"
    wrongs = []
    if digest(data / "beam.mote") != before:
        wrongs.append("the dataset that was there before is another")
    output = data / "wanted.mote"
    if output.exists():
        done = subprocess.run([build / "bin" / "mote-prep", "verify", output], capture_output=True, check=False)
        if done.returncode != 0:
            wrongs.append("a dataset is visible that is not whole")
    elif job.state == "succeeded":
        wrongs.append("the job succeeded and made nothing")
    if job.state == "failed" and not is_sentence(job.error):
        wrongs.append(f"no clear error: {job.error!r}")
    if job.finished and list(data.glob("*.partial-*")):
        wrongs.append("the unfinished dataset is left")
    return wrongs


def fill_outputs(build, here, steps, verdict):
    """Jobs that have less and less room for what they make."""
    mount(here / "data")
    own_server.make_beam(build, here / "data")
    before = digest(here / "data" / "beam.mote")
    needed = sum(path.stat().st_size for path in (here / "data" / "beam.mote").rglob("*") if path.is_file())
    for step in range(steps):
        room = needed * 2 * step // steps // PAGE * PAGE
        with own_server.OwnServer(build / "bin" / "mote-server", here) as server, server.session() as session:
            leave(here / "data", room)
            job = submit(session, "wanted")
            wait(job)
            wrongs = judge_output(build, here, job, before)
            (here / "data" / "ballast").unlink()
            if job.waits_for:
                job.cancel()
            if server.is_hurt():
                wrongs.append("the server died")
            verdict.add(f"outputs with {room} bytes of room", wrongs, job.state != "succeeded")
        subprocess.run(["rm", "-rf", here / "data" / "wanted.mote", here / "state"], check=True)
    unmount(here / "data")


def use_full_state(server, told):
    """Jobs, as far as the state takes them; how many were refused."""
    refused = 0
    with server.session() as session:
        for number in range(8):
            try:
                job = submit(session, f"job-{number}")
                if number % 2:
                    job.cancel()
            except mote.Error as error:
                refused += 1
                if not is_sentence(str(error)):
                    raise
        told.update({identity: status.state for identity, status in session.connection.jobs.items()})
    return refused


def judge_state(build, here, told, may_fail=False):
    """Room again, and a server that is started anew: what was told is there and still holds."""
    wrongs = []
    with own_server.OwnServer(build / "bin" / "mote-server", here) as server, server.session() as session:
        known = {job.id: job for job in session.jobs}
        for identity, state in told.items():
            if identity not in known:
                wrongs.append(f"job {identity} is lost")
            elif state > 2 and known[identity].status.state != state:
                wrongs.append(f"job {identity} was told another end")
        for job in known.values():
            wait(job)
            if job.state == "failed" and not (may_fail and is_sentence(job.error)):
                wrongs.append(f"job {job.id} failed for a fault of the place: {job.error}")
    for output in (here / "data").glob("job-*"):
        shutil.rmtree(output)
    return wrongs


def fill_state(build, here, steps, verdict):
    """A server whose own folder has less and less room."""
    own_server.make_beam(build, here / "data")
    for step in range(steps):
        mount(here / "state")
        told, refused, wrongs = {}, 0, []
        with own_server.OwnServer(build / "bin" / "mote-server", here) as server:
            leave(here / "state", PAGE * step * 2)
            refused = use_full_state(server, told)
            if server.is_hurt():
                wrongs.append("the server died")
        (here / "state" / "ballast").unlink()
        wrongs += judge_state(build, here, told)
        verdict.add(f"a state with {PAGE * step * 2} bytes of room", wrongs, refused > 0)
        unmount(here / "state")


def limit_sizes(build, here, verdict):
    """Files of the server and its jobs may not grow beyond a limit: errors, no SIGXFSZ."""
    own_server.make_beam(build, here / "data")
    for limit in (64 << 10, 256 << 10, 1 << 20):
        told, wrongs = {}, []
        subprocess.run(["rm", "-rf", here / "state"], check=True)

        def shrink(most=limit):
            resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))

        try:
            with own_server.OwnServer(build / "bin" / "mote-server", here, preexec_fn=shrink) as server:
                refused = use_full_state(server, told)
                if server.is_hurt():
                    wrongs.append("the server died")
        except own_server.NotReady:
            refused = 1
            if b"mote-server: " not in (here / "server.log").read_bytes():
                wrongs.append("it does not start and does not say why")
        # A job has the limit of the server that began it: what does not fit has failed.
        wrongs += judge_state(build, here, told, may_fail=True)
        verdict.add(f"files of {limit} bytes at most", wrongs, refused > 0)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    own_server.add_build(parser)
    parser.add_argument("--steps", default=12, type=int, help="amounts of room of each disk")
    options = parser.parse_args()
    disks = enter_namespace()
    verdict = Verdict()
    with tempfile.TemporaryDirectory(prefix="mote-full-") as name:
        folder = pathlib.Path(name).resolve()
        for part in ("outputs", "state", "sizes"):
            (folder / part).mkdir()
        if disks:
            fill_outputs(options.build, folder / "outputs", options.steps, verdict)
            fill_state(options.build, folder / "state", options.steps, verdict)
        else:
            print("full disks are left out: nothing may be mounted here")
        limit_sizes(options.build, folder / "sizes", verdict)
    print(f"{verdict.tried} times too little room, {verdict.refused} of them refused in a sentence: "
          f"{verdict.broken} broke the promise")
    return 1 if verdict.broken else 0


if __name__ == "__main__":
    sys.exit(main())
