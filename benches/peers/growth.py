"""How the cost of an update grows with the graph: seconds ∝ nᵖ, p by least squares over whole sequences 1e4 → 1e6.

    python growth.py --work target/peers [--binary target/release/eigentrail]
"""

import argparse
import json
import subprocess
from pathlib import Path

import numpy as np

import graphs

ROOT = Path(__file__).resolve().parent.parent.parent
FAMILIES = ("grid", "rooms", "maze")


def exponent(binary: Path, file: Path) -> tuple[float, float]:
    """p and its standard error."""
    command = [binary, "track", file, "--k", "16", "--tol", "1e-2", "--growth", "0.05", "--from", "10000", "--threads", "1", "--json", "--quiet"]
    report = json.loads(subprocess.run([str(c) for c in command], capture_output=True, check=True, text=True).stdout)
    updates = [u for u in report["updates"] if not u["cold_start"]]
    sizes, seconds = (np.log([u[key] for u in updates]) for key in ("nodes", "seconds"))
    (p, _), covariance = np.polyfit(sizes, seconds, 1, cov=True)
    return float(p), float(np.sqrt(covariance[0, 0]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--binary", type=Path, default=ROOT / "target/release/eigentrail")
    parser.add_argument("--work", type=Path, default=ROOT / "target/peers")
    args = parser.parse_args()
    for family in FAMILIES:
        p, error = exponent(args.binary, graphs.path_of(args.work, family, "1e6", "frontier"))
        print(f"{family}: p = {p:.3f} ± {error:.3f}", flush=True)


if __name__ == "__main__":
    main()
