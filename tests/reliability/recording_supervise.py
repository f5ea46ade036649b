#!/usr/bin/python3 -IBS
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands in mote-supervise's place: writes down what a job would be run with, and runs nothing.

FOLDER/runs/ID gets {"words": ..., "request": ..., "environment": ...}; FOLDER is that of this file. The job fails.
"""
import json
import os
import sys

GATE = 3


def main():
    if os.read(GATE, 1) != b"g":
        return 0
    directory = sys.argv[sys.argv.index("--directory") + 1]
    with open(os.path.join(directory, "request.json"), encoding="utf-8", newline="") as file:
        request = file.read()
    folder = os.path.dirname(os.path.abspath(sys.argv[0]))
    run = {"words": sys.argv[1:], "request": request, "environment": sorted(os.environ)}
    with open(os.path.join(folder, "runs", os.path.basename(directory)), "w", encoding="utf-8") as file:
        json.dump(run, file)
    with open(os.path.join(directory, "result.new"), "w", encoding="ascii") as file:
        file.write("exit 3")
    os.rename(os.path.join(directory, "result.new"), os.path.join(directory, "result"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
