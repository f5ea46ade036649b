# SPDX-License-Identifier: GPL-3.0-or-later
# Asks bench-numbers for the numbers of a plot that has none: without_columns.sh MOTE-PREP BENCH-NUMBERS.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$1" synth beam --particles 1000 --steps 1 --seed 1 --out "$folder/run.h5" > /dev/null
"$1" particles "$folder/run.h5" --axes x,px,y --columns none --out "$folder/run.mote" > /dev/null
status=0
"$2" "$folder/run.mote" > "$folder/said" 2>&1 || status=$?
cat "$folder/said"
[ "$status" = 1 ]
[ "$(wc -l < "$folder/said")" = 1 ]
grep -q 'was made without columns' "$folder/said"
