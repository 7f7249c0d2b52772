#!/usr/bin/env bash
# Tests of what needs Stable-Baselines3, TorchRL or PyTorch Geometric, and of the examples of their docstrings, as test.sh
# does the others. Downloads PyTorch: several gigabytes where no wheel without CUDA is at hand.
set -euo pipefail
cd "$(dirname "$0")"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${EIGENTRAIL_PYTHON:-python3}" -m venv "$work/venv"
python="$work/venv/bin/python"
pip() { "$python" -m pip --disable-pip-version-check --quiet "$@"; }

pip install "maturin>=1.9.4,<2"
"$work/venv/bin/maturin" build --release --locked --out "$work/wheels"
pip install "$(echo "$work"/wheels/*.whl)[test,sb3,torchrl,pyg]"

cp -r tests_outside "$work"
cd "$work"
"$python" -m pytest --quiet -p no:cacheprovider tests_outside "$@"
"$python" -m pytest --quiet -p no:cacheprovider --doctest-modules --pyargs eigentrail.sb3 eigentrail.torchrl
