#!/usr/bin/env bash
# Regenerates the tables of docs/learning.md: every world, every arm, fresh seeds from 1000, into the folder OUT.
# Usage: benches/learning/table.sh [OUT] [small|large|huge|all]; goes on where it was if OUT exists.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=${1:-runs/learning}
which=${2:-all}
arms=sparse,gcn,heat,hops,oracle,gcn-shaping-only,q-learning,dyna-q,planner,report

cargo build --release --locked --quiet
table() { # name, seeds, worlds...
    local name=$1 seeds=$2
    shift 2
    mkdir -p "$out"
    target/release/eigentrail compare "$@" --seeds "$seeds" --arms "${table_arms:-$arms}" \
        ${tuned---tuned} --resume --markdown --out "$out/$name" | tee "$out/$name.md"
}

case $which in small | all)
    table small 1000..1020 open_5x5 four_rooms linked_grids open_15x15 rooms_25x25
    table hard 1000..1020 u_trap spiral one_way centre_goal random_start two_goals rewarded_goals
    table slip 1000..1020 four_rooms_slip rooms_25x25_slip
    ;;
esac
case $which in large | all) table large 1000..1010 rooms_50x50 open_50x50 ;; esac
# Beyond this the learners without guidance take hours for nothing: the ratio to sparse is all they are needed for.
table_arms=sparse,gcn,heat,planner tuned=
case $which in huge | all) table huge 1000..1010 rooms_100x100 open_100x100 maze_101 ;; esac
