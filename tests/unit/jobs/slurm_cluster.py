#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A cluster of one node, of Debian's Slurm, while a command runs: munged, slurmctld and slurmd are processes of this
script, with their files in a folder of its own.

    slurm_cluster.py COMMAND [ARGUMENT]...

The command finds it by SLURM_CONF. Exits as the command does, with 77 where this machine has no Slurm.
"""
import os
import pathlib
import pwd
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

NO_SLURM = 77
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel")
PATIENCE = 60  # s, of a broken cluster

CONF = """ClusterName=mote
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={control}
SlurmdPort={node}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
SchedulerType=sched/builtin
SchedulerParameters=sched_interval=1,batch_sched_delay=0
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
MinJobAge={age}
KillWait=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=2000
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP OverSubscribe=FORCE:4
"""


def find(program):
    return shutil.which(program, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


class Cluster:
    def __init__(self, folder):
        self.folder = folder
        self.processes = []
        self.environment = dict(os.environ, SLURM_CONF=str(folder / "slurm.conf"))

    def begin(self):
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        key = self.folder / "munge.key"
        key.write_bytes(secrets.token_bytes(128))
        key.chmod(0o400)
        (self.folder / "slurm.conf").write_text(CONF.format(
            host=socket.gethostname().split(".")[0], control=free_port(), node=free_port(), folder=self.folder,
            user=pwd.getpwuid(os.geteuid()).pw_name, age=os.environ.get("MOTE_SLURM_AGE", "300")))
        self.start("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={self.folder}/munge.socket",
                   f"--pid-file={self.folder}/munge.pid", f"--log-file={self.folder}/munge.log",
                   f"--seed-file={self.folder}/munge.seed", "--num-threads=2")
        self.wait_for(lambda: (self.folder / "munge.socket").exists())
        conf = str(self.folder / "slurm.conf")
        self.start("slurmctld", "-D", "-f", conf)
        self.start("slurmd", "-D", "-f", conf)
        self.wait_for(lambda: self.ask("sinfo", "--noheader", "--format=%T") == "idle")

    def start(self, program, *words):
        output = open(self.folder / f"{program}.out", "wb")
        process = subprocess.Popen([find(program), *words], env=self.environment, stdout=output, stderr=output,
                                   stdin=subprocess.DEVNULL)
        self.processes.append(process)
        return process

    def ask(self, program, *words):
        done = subprocess.run([find(program), *words], env=self.environment, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, check=False, timeout=PATIENCE)
        return done.stdout.decode().strip()

    def wait_for(self, wanted):
        end = time.monotonic() + PATIENCE
        while not wanted():
            ended = [p.args[0] for p in self.processes if p.poll() is not None]
            if ended or time.monotonic() > end:
                raise RuntimeError(f"the cluster does not begin: {ended}\n{self.logs()}")
            time.sleep(0.05)  # between two looks at what other processes do

    def logs(self):
        files = sorted(self.folder.glob("*.log")) + sorted(self.folder.glob("*.out"))
        return "\n".join(f"== {f.name}\n{f.read_text(errors='replace')[-2000:]}" for f in files)

    def end(self):
        for process in reversed(self.processes):
            process.send_signal(signal.SIGTERM)
        for process in reversed(self.processes):
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def main():
    missing = [program for program in PROGRAMS if find(program) is None]
    if missing:
        print(f"skipped: this machine has no {', '.join(missing)}")
        return NO_SLURM
    # munged trusts no folder that others may write to, above its own.
    base = os.environ.get("MOTE_SLURM_FOLDER") or ("/run" if os.geteuid() == 0 else None)
    with tempfile.TemporaryDirectory(prefix="mote-slurm-", dir=base) as name:
        cluster = Cluster(pathlib.Path(name))
        try:
            cluster.begin()
            code = subprocess.run(sys.argv[1:], env=cluster.environment, check=False).returncode
            if code != 0:
                print(cluster.logs())
            return code
        finally:
            cluster.end()


if __name__ == "__main__":
    sys.exit(main())
