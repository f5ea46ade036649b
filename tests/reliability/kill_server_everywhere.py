#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""mote-server hurt at its writes, fsyncs and renames while jobs are submitted, run and cancelled; and their supervisor.

    kill_server_everywhere.py [--build build/release] [--every 5] [--most 60] [--seed 15]

The server is killed at every so many-th call of a kind; calls on the database of jobs are told that the disk is full or
fails; a job's supervisor and program are killed at theirs. After each fault all of the server is killed and started
again. A job whose id was told is there, what was told of its end still holds, none fails for a fault of the place, none
runs beside itself or more often than it was interrupted and once, what succeeded is whole, and a job's death is none of
the server's. Prints how many faults there were, what broke, and how long the slowest restart took (a promise of 5 s);
exits 1 where anything broke.
"""
import argparse
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

import own_server
import strace_faults

mote = own_server.mote

DATABASES = [name + suffix for name in ("jobs.sqlite", "jobs.copy.sqlite") for suffix in ("", "-wal", "-shm", "-journal")]
STATES = ("unknown", "queued", "running", "succeeded", "failed", "cancelled")
RESTART_S = 5.0
PATIENCE_S = 60.0
# Of a disk; the server's other writes go to sockets and pipes, which are never full.
DISK_CALLS = ("pwrite64", "fsync", "fdatasync", "ftruncate", "unlink")


class Place:
    """A folder with a run, and programs of which the supervisor is counted."""

    def __init__(self, folder, build):
        self.folder, self.bin = folder, folder / "bin"
        self.prep = (build / "bin" / "mote-prep").resolve()
        (self.bin / "runs").mkdir(parents=True)
        shutil.copy2((build / "bin" / "mote-server").resolve(), self.bin / "mote-server")
        os.symlink(self.prep, self.bin / "mote-prep")
        shutil.copy2(pathlib.Path(__file__).with_name("counting_supervise.py"), self.bin / "mote-supervise")
        (self.bin / "supervise").write_text(str((build / "bin" / "mote-supervise").resolve()), encoding="utf-8")
        own_server.make_beam(build, folder / "source")
        self.number = 0

    def fresh(self):
        """A server's folder for one fault."""
        self.number += 1
        here = self.folder / f"fault-{self.number}"
        (here / "data").mkdir(parents=True)
        (here / "state").mkdir(mode=0o700)
        shutil.copy(self.folder / "source" / "run.h5", here / "data" / "run.h5")
        return here

    def server(self, here, before=()):
        return own_server.OwnServer(self.bin / "mote-server", here, before=before)

    def hurt_jobs(self, words):
        (self.bin / "hurt").write_text(words, encoding="utf-8")

    def runs(self, identity):
        path = self.bin / "runs" / identity
        return path.read_text(encoding="ascii").splitlines() if path.exists() else []

    def verifies(self, dataset):
        return subprocess.run([self.prep, "verify", dataset], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              check=False).returncode == 0


def submit(session, name):
    return session.prepare("data/run.h5", axes=["x", "px", "y"], output=f"data/{name}.mote")


def follow(server, job):
    """Until it has ended or the server is hurt."""
    end = time.monotonic() + PATIENCE_S
    while not job.finished and not server.is_hurt() and time.monotonic() < end:
        try:
            job.wait(timeout=0.5, progress=False)
        except mote.Error as error:
            if not job.finished and error.where != job.id:  # that was no end of patience
                raise


def use(server, told):
    """Jobs, until all is done or the server is hurt; fills {id: JobStatus} of all that was told."""
    session = server.session()
    try:
        jobs = [submit(session, name) for name in ("a", "b", "c", "d")]
        jobs[2].cancel()
        jobs[3].cancel()
        for job in jobs[:2]:
            follow(server, job)
        if not server.is_hurt():
            running = submit(session, "e")
            session.connection.wait_for(lambda: running.state != "queued", PATIENCE_S)
            running.cancel()
            follow(server, running)
    finally:
        told.update(session.connection.jobs)
        session.close()


class Verdict:
    """What broke, of all faults."""

    def __init__(self):
        self.faults = self.broken = self.told = self.hits = 0
        self.slowest = 0.0

    def add(self, name, wrongs, told, hurt):
        self.faults += 1
        self.told += len(told)
        self.hits += hurt
        self.broken += bool(wrongs)
        for wrong in wrongs:
            print(f"{name}: {wrong}", flush=True)


def judge_job(place, here, told, now, places_fault):
    """What is wrong with one job, from what was told of it and how it ended in the end."""
    was, state = STATES[told.state], STATES[now.state]
    if told.state > 2 and was != state:
        yield f"job {told.id} was told to be {was} and is {state}"
    if state == "failed" and places_fault:
        yield f"job {told.id} failed for a fault of the place: {now.error}"
    runs = place.runs(told.id)
    if len(runs) > 1 + now.interrupted:
        yield f"job {told.id} ran {len(runs)} times and was interrupted {now.interrupted} times"
    if any(line.endswith("beside") for line in runs):
        yield f"job {told.id} ran beside itself"
    output = here / now.request.output
    if state == "succeeded" and not place.verifies(output):
        yield f"job {told.id} succeeded and {now.request.output} is not whole"
    if state != "succeeded" and output.exists():
        yield f"job {told.id} is {state} and {now.request.output} is there"


def judge(place, here, told, verdict, places_fault=True):
    """Starts the server anew, without faults, lets all jobs end, and says what is wrong."""
    place.hurt_jobs("")
    try:
        server = place.server(here)
    except own_server.NotReady as failure:
        return [f"it does not start again: {failure}"]
    wrongs = []
    with server:
        verdict.slowest = max(verdict.slowest, server.seconds)
        if server.seconds > RESTART_S:
            wrongs.append(f"the restart took {server.seconds:.1f} s")
        with server.session() as session:
            known = {job.id: job for job in session.jobs}
            for job in known.values():
                follow(server, job)
            for identity, status in told.items():
                if identity not in known:
                    wrongs.append(f"job {identity} is lost")
                    continue
                if not known[identity].finished:
                    wrongs.append(f"job {identity} does not end: {known[identity].waits_for}")
                wrongs += judge_job(place, here, status, known[identity].status, places_fault)
        wrongs += [f"a draft is left: {draft.name}" for draft in (here / "data").glob("*.partial-*")]
        if server.is_hurt():
            wrongs.append("the server that was started again died")
    return wrongs


def tracer(here, call, k, fault, files):
    """Words before the server's: strace, which follows it and not its jobs."""
    words = ["strace", "-f", "-qq", "-b", "execve", "-o", "/dev/null", "-e", f"trace={call}", "-e",
             f"inject={call}:{fault}:when={k}"]
    for name in files:
        words += ["-P", here / "state" / name]
    return words


def hurt_once(place, verdict, fault, call, k, files=()):
    here, told = place.fresh(), {}
    hurt = False
    try:
        with place.server(here, tracer(here, call, k, fault, files)) as server:
            try:
                use(server, told)
            except mote.Error as error:  # its answer to a fault is a sentence
                if "\n" in str(error):
                    verdict.add(fault, [f"no sentence: {error}"], {}, False)
            hurt = server.is_hurt()
            if hurt and fault.startswith("error"):
                verdict.add(f"{fault} at {call} {k}", ["the server died"], told, True)
    except own_server.NotReady:
        hurt = True  # at its start, before anything was told
    verdict.add(f"{fault} at {call} {k}", judge(place, here, told, verdict), told, hurt)
    shutil.rmtree(here, ignore_errors=True)


def count_calls(place, calls, files=()):
    """Of a server that is not hurt, as strace_faults.count_calls has it."""
    here, told = place.fresh(), {}
    log = here / "calls"
    words = ["strace", "-f", "-qq", "-b", "execve", "-o", log, "-e", "trace=" + ",".join(calls)]
    for name in files:
        words += ["-P", here / "state" / name]
    with place.server(here, words) as server:
        use(server, told)
    shutil.rmtree(here / "data")
    return strace_faults.count_calls(log.read_text(encoding="utf-8", errors="replace"))


def hurt_job_once(place, verdict, call, k):
    """Kills a job's supervisor, or its program, at their k-th call; the server must not notice more than that."""
    here, told = place.fresh(), {}
    place.hurt_jobs(f"strace -f -qq -o /dev/null -e trace={call} -e inject={call}:signal=KILL:when={k}")
    wrongs = []
    with place.server(here) as server:
        with server.session() as session:
            follow(server, submit(session, "a"))
            told.update(session.connection.jobs)
        if server.is_hurt():
            wrongs.append("the server died of a job's death")
    wrongs += judge(place, here, told, verdict, places_fault=False)
    verdict.add(f"job killed at {call} {k}", wrongs, told, True)
    shutil.rmtree(here, ignore_errors=True)


def draw(plan, most, seed):
    plan = list(plan)
    return random.Random(seed).sample(plan, min(most, len(plan))) if most else plan


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    own_server.add_build(parser)
    parser.add_argument("--every", default=5, type=int, help="of calls of one kind, only every so many-th is hurt")
    parser.add_argument("--most", default=60, type=int, help="so many faults of a kind at most, drawn by lot; 0: all")
    parser.add_argument("--seed", default=15, type=int)
    options = parser.parse_args()
    if shutil.which("strace") is None:
        print("skipped: this machine has no strace")
        return 77
    verdict = Verdict()
    with tempfile.TemporaryDirectory(prefix="mote-faults-") as name:
        place = Place(pathlib.Path(name).resolve(), options.build)
        killed = strace_faults.places(count_calls(place, strace_faults.WRITES), options.every)
        for call, k in draw(killed, options.most, options.seed):
            hurt_once(place, verdict, "signal=KILL", call, k)
        disk = list(strace_faults.places(count_calls(place, DISK_CALLS, DATABASES), options.every))
        for fault in ("error=ENOSPC", "error=EIO"):
            for call, k in draw(disk, options.most, options.seed):
                hurt_once(place, verdict, fault, call, k, DATABASES)
        jobs = [(call, k) for call in ("write", "pwrite64", "fsync", "rename", "renameat2") for k in (1, 2, 3, 5, 8, 13)]
        for call, k in draw(jobs, options.most, options.seed):
            hurt_job_once(place, verdict, call, k)
    print(f"{verdict.faults} faults, {verdict.hits} deaths, {verdict.told} jobs told: {verdict.broken} faults broke the "
          f"promise; the slowest restart took {verdict.slowest:.2f} s")
    return 1 if verdict.broken or not verdict.faults else 0


if __name__ == "__main__":
    sys.exit(main())
