#!/usr/bin/env bash
# Regenerates the tables of docs/learning.md: every world, every arm, fresh seeds from 1000, into the folder OUT.
# Usage: benches/learning/table.sh [OUT] [small|large|huge|all]; goes on where it was if OUT exists.
#
# Seconds of one core, estimated from one or two seeds of each part; four idle cores take about five minutes:
#
#   small   small      5 worlds × 20 seeds, all arms, tuned      40
#           hard       8 worlds × 20 seeds, all arms, tuned      70
#           slip       2 worlds × 20 seeds, all arms, tuned     480   nearly all of it is the planner's
#           slip-0.1   2 worlds × 20 seeds, four arms           200   the same
#   large   large      20 seeds, open field 30, all arms, tuned 160
#   huge    huge       10 seeds, open field 30, four arms       120
#           200        10 seeds, four arms                      250   of it 70 for the sparse arm
#
# Open fields get more seeds, because there the search for the first goal is a matter of luck.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=${1:-runs/learning}
which=${2:-all}
every_arm=sparse,gcn,heat,hops,oracle,gcn-shaping-only,q-learning,dyna-q,planner,report
# Beyond 10⁴ states, learners without guidance get nowhere: one of them is enough for the ratio.
four_arms=sparse,gcn,heat,planner

cargo build --release --locked --quiet
table() { # name, seeds, arms, worlds and options...
    local name=$1 seeds=$2 arms=$3
    shift 3
    mkdir -p "$out"
    target/release/eigentrail compare "$@" --seeds "$seeds" --arms "$arms" \
        --resume --markdown --out "$out/$name" | tee "$out/$name.md"
}

case $which in small | all)
    table small 1000..1020 $every_arm --tuned open_5x5 four_rooms linked_grids open_15x15 rooms_25x25
    table hard 1000..1020 $every_arm --tuned \
        u_trap spiral one_way centre_goal random_start two_goals rewarded_goals moving_goal
    table slip 1000..1020 $every_arm --tuned four_rooms_slip rooms_25x25_slip
    table slip-0.1 1000..1020 $four_arms --set env.slip=0.1 four_rooms_slip rooms_25x25_slip
    ;;
esac
case $which in large | all)
    table large 1000..1020 $every_arm --tuned rooms_50x50
    table large-open 1000..1030 $every_arm --tuned open_50x50
    ;;
esac
case $which in huge | all)
    table huge 1000..1010 $four_arms rooms_100x100 maze_101
    table huge-open 1000..1030 $four_arms open_100x100
    table 200 1000..1010 $four_arms rooms_200x200 maze_201
    ;;
esac
