#!/usr/bin/env bash
# Builds the wheel, installs it into a clean virtual environment, and runs the tests and all examples of the docstrings
# there. Needs Rust, and a Python of 3.11 or later with pip: python3, or the one that EIGENTRAIL_PYTHON names.
set -euo pipefail
cd "$(dirname "$0")"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${EIGENTRAIL_PYTHON:-python3}" -m venv "$work/venv"
python="$work/venv/bin/python"
pip() { "$python" -m pip --disable-pip-version-check --quiet "$@"; }

pip install "maturin>=1.9.4,<2"
"$work/venv/bin/maturin" build --release --locked --out "$work/wheels"
pip install "$(echo "$work"/wheels/*.whl)[test]"

# From elsewhere: it is the wheel that is tested, not the folder it was built from.
mkdir "$work/python" "$work/docs"
cp -r tests examples benches README.md "$work/python"
cp ../docs/tutorial.md "$work/docs"
cd "$work/python"
"$python" -m pytest --quiet -p no:cacheprovider tests "$@"
# What needs more than this is tested by test_outside.sh.
"$python" -m pytest --quiet -p no:cacheprovider --doctest-modules --pyargs eigentrail \
    --ignore-glob='/*/eigentrail/sb3*' --ignore-glob='/*/eigentrail/torchrl.py'
