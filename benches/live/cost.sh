#!/bin/sh
# What following a run in a browser costs it: steps per second of runs of about a minute, alternately without and with
# a headless Chromium on the live page. Prints a line for each pair and the median loss.
#
#   benches/live/cost.sh [PAIRS] [SCENARIO] [EPISODES]
set -eu
pairs=${1:-3} scenario=${2:-rooms_50x50} episodes=${3:-100000}
eigentrail=${EIGENTRAIL:-target/release/eigentrail}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Steps per second of one run; further arguments go to it.
speed() {
    "$eigentrail" run "$scenario" -q --no-report --json --set run.episodes="$episodes" --force --out "$folder/run" "$@" |
        sed 's/.*"steps_per_second":\([0-9.]*\).*/\1/'
}

follow() {
    chromium --headless=new --no-sandbox --disable-gpu --no-first-run --user-data-dir="$folder/profile" \
        http://127.0.0.1:8765/ >/dev/null 2>&1 &
    browser=$!
}

echo "pair  alone  followed  loss"
for pair in $(seq "$pairs"); do
    alone=$(speed)
    (sleep 1; follow; echo "$browser" >"$folder/browser") &
    followed=$(speed --serve)
    kill "$(cat "$folder/browser")" 2>/dev/null || true
    sleep 2 # for its children still write into the folder
    echo "$pair $alone $followed" | awk '{ printf "%d  %.0f  %.0f  %.2f %%\n", $1, $2, $3, 100 * (1 - $3 / $2) }' | tee -a "$folder/pairs"
done
sort -k4,4n "$folder/pairs" | awk '{ loss[NR] = $4 } END {
    print "median loss", (loss[int((NR + 1) / 2)] + loss[int(NR / 2) + 1]) / 2, "%" }'
