# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults at the k-th call of a kind, by strace: which calls a program makes, and a run of it with one of them hurt."""
import collections
import re
import subprocess

WRITES = ("write", "pwrite64", "writev", "pwritev", "fsync", "fdatasync", "rename", "renameat", "renameat2", "ftruncate",
          "fallocate", "mkdir", "mkdirat", "unlink", "unlinkat", "msync", "sync_file_range")
_CALL = re.compile(r"^(\d+) +(\w+)\(")


def count_calls(log):
    """The most calls of each kind that any one thread made, in the lines of `strace -f -o`."""
    counts = collections.Counter()
    for line in log.splitlines():
        found = _CALL.match(line)
        if found:
            counts[found.group(1), found.group(2)] += 1
    most = {}
    for (_, call), count in counts.items():
        most[call] = max(most.get(call, 0), count)
    return most


def calls_of(command, log, calls=WRITES, environment=None):
    """What the command calls, as count_calls has it. It must end well."""
    traced = ["strace", "-f", "-qq", "-o", str(log), "-e", "trace=" + ",".join(calls), *map(str, command)]
    subprocess.run(traced, check=True, stdout=subprocess.DEVNULL, env=environment)
    return count_calls(log.read_text())


def places(counts, every):
    """(call, k) for each k-th call of each kind; of many only every so many-th, the first and the last always."""
    for call, count in sorted(counts.items()):
        for k in range(1, count + 1):
            if k in (1, count) or k % every == 0:
                yield call, k


def run_hurt(command, call, k, fault, environment=None):
    """Runs the command with `fault` ("signal=KILL", "error=ENOSPC") at its k-th `call`, of each thread."""
    traced = ["strace", "-f", "-qq", "-o", "/dev/null", "-e", f"trace={call}", "-e", f"inject={call}:{fault}:when={k}",
              *map(str, command)]
    return subprocess.run(traced, check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)
