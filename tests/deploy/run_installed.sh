#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# What deploy/check-packages runs where the packages are installed: from a run to a picture, and the server's end.
set -euo pipefail
cd ~

mkdir data
mote-prep synth beam --particles 100000 --steps 1 --seed 1 --out data/run.h5
mote-prep particles data/run.h5 --axes x,px,y --out data/beam.mote
cat >server.toml <<'END'
root = ["data=/root/data"]
state = "/root/state"
connection = "/root/connection.json"
device = "auto" # nothing that draws on a GPU is installed
log = "/root/server.log"
log-format = "json"
metrics = "unix:/root/metrics.sock"
END
mote-server --check-config --config server.toml
coproc server { exec mote-server --config server.toml; }
# shellcheck disable=SC2154  # coproc sets it
pid=$server_PID
read -r -t 60 ready <&"${server[0]}"
echo "$ready"
[[ $ready == "ready /root/connection.json "* ]]
cat >view.json <<'END'
{"views": [{"width": 640, "height": 360,
  "camera": {"eye": [1.3, 0.9, 2.9], "target": [0, 0, 0], "up": [0, 1, 0], "fovYDegrees": 35},
  "layers": [{"dataset": "data/beam", "particles": {}}]}]}
END
mote-frames view.json --connect connection.json --out pictures --quiet
test -s pictures/frame-000000.png
mote-stats data/beam --connect connection.json --json >numbers.json
test -s numbers.json
# A job, under all its limits: mote-supervise and mote-prep, from the server that is installed.
mote-stats data/beam --connect connection.json --export beam.h5
test -s beam.h5
grep '"job"' server.log | grep -q 'ended: succeeded'
# The package for Python, by the server that is installed.
python3 -c 'import mote; s = mote.spawn(data="data"); mote.View(s["data/beam"], size=(320, 200)).render().save("beam.png")'
test -s beam.png
mote prep --version
# mote-view has no screen here; that its libraries are there is what can be seen.
mote-view --help >/dev/null
kill -TERM "$pid"
wait "$pid"
test ! -e connection.json
grep -c '"kind"' server.log
