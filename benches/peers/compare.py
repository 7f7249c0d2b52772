"""Runs `eigentrail track` and the peers by turns on the same files and prints ratios. See README.md."""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from dataclasses import asdict, replace
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent

GROWTH = 0.05
LAST = 5  # updates whose mean is "the last updates"
MOST_TIGHTENINGS = 3


def options() -> argparse.Namespace:
    from rows import PRESETS

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--preset", choices=PRESETS, default="full")
    parser.add_argument("--quick", dest="preset", action="store_const", const="quick", help="ten minutes at most")
    parser.add_argument("--only", nargs="*", default=[], metavar="WORD", help="rows whose name holds every word, e.g. --only 1e5 maze k=32")
    parser.add_argument("--peers", nargs="*", help="these peers instead of the preset's")
    parser.add_argument("--repeats", type=int, help="instead of the preset's")
    parser.add_argument("--binary", type=Path, default=ROOT / "target/release/eigentrail")
    parser.add_argument("--work", type=Path, default=ROOT / "target/peers", help="graphs, references and settings are kept here")
    parser.add_argument("--out", type=Path, help="results as OUT.json, OUT.md and OUT.txt [default: WORK/result]")
    parser.add_argument("--page", type=Path, help="put the table between the markers of this page, e.g. docs/spectra.md")
    parser.add_argument("--flag", action="append", default=[], help="passed on to `eigentrail track`, e.g. --flag=--certify")
    parser.add_argument("--list", action="store_true", help="print the rows' names and stop")
    return parser.parse_args()


def run_worker(job: dict) -> dict:
    """One contender in a process of its own with as many BLAS threads as the row has."""
    threads = str(job["threads"])
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    environment = dict(os.environ, **dict.fromkeys(names, threads))
    worker = [sys.executable, str(HERE / "worker.py")]
    done = subprocess.run(worker, input=json.dumps(job), capture_output=True, text=True, env=environment)
    if done.returncode:
        return dict(failed=f"exit code {done.returncode}: {done.stderr[-300:]}")
    return json.loads(done.stdout.splitlines()[-1])


def note(text: str) -> None:
    print(time.strftime("%H:%M:%S"), text, file=sys.stderr, flush=True)


class Comparison:
    """One row: calibrates the peers, runs everybody by turns, checks every list."""

    def __init__(self, row, args):
        import graphs
        import problem
        import reference

        self.row, self.args = row, args
        file = graphs.path_of(args.work, row.family, row.size, row.order)
        n = problem.load(file).shape[0]
        start = 64 if row.kind == "sequence" else round(n / (1 + GROWTH))
        self.sizes = problem.sizes(n, GROWTH, start)
        self.exact = reference.lists(file, self.sizes, args.work, note)
        self.job = dict(file=str(file), k=row.k, tau=row.tau, threads=row.threads, growth=GROWTH, sizes=self.sizes, unit=float(self.exact[0][row.k - 1]), flags=args.flag)

    def run(self) -> dict:
        contenders = {"eigentrail": self.ours, **{peer: self.peer(peer) for peer in self.row.peers}}
        runs = {name: [] for name in contenders}
        for repeat in range(self.row.repeats):
            names = list(contenders)
            turn = repeat % len(names)
            for name in names[turn:] + names[:turn]:
                result = contenders[name]()
                runs[name].append(self.judged(result))
                note(f"  {self.row.name()}: {name} {shown(runs[name][-1])}")
        return dict(row=asdict(self.row), runs=runs)

    def ours(self) -> dict:
        return run_worker(dict(self.job, peer="eigentrail", binary=str(self.args.binary.resolve())))

    def peer(self, peer: str):
        """Measures the peer; where a residual is too large, tightens its tolerance and repeats."""
        import graphs
        import settings

        row = self.row
        small = graphs.path_of(self.args.work, row.family, "1e4", row.order)
        job = dict(self.job, peer=peer, threads=1, file=str(small))
        chosen = settings.calibrated(self.args.work / "settings.json", f"{row.family} {row.order}", job, run_worker)
        warm = peer in ("cholmod-warm", "primme", "lobpcg-amg")
        sizes = self.sizes if warm or row.kind == "sequence" else self.sizes[-1:]
        state = dict(settings=chosen, tightened=0)

        def measure() -> dict:
            while True:
                result = run_worker(dict(self.job, peer=peer, sizes=sizes, settings=state["settings"]))
                result["settings"] = state["settings"]
                late = any(u["residual"] > row.tau for u in result.get("updates", []))
                if not late or state["tightened"] == MOST_TIGHTENINGS:
                    return result
                state.update(settings=settings.tightened(state["settings"]), tightened=state["tightened"] + 1)
                note(f"  {peer} misses the residual: now {state['settings']}")

        return measure

    def judged(self, result: dict) -> dict:
        """The facts of one run that the table is made of."""
        import numpy as np
        import problem

        if "failed" in result:
            return result
        clock = "cpu" if self.row.threads == 1 else "wall"
        exact = dict(zip(self.sizes, self.exact))
        updates = result.pop("updates")
        errors = [problem.list_error(np.array(u["eigenvalues"]), exact[u["nodes"]]) for u in updates]
        seconds = [u[clock] for u in updates]
        tail = seconds[-1:] if self.row.kind == "update" else seconds[-LAST:]
        return dict(
            result,
            total=sum(seconds),
            last=statistics.mean(tail),
            updates=len(updates),
            worst_residual=max(u["residual"] for u in updates),
            late=sum(u["residual"] > self.row.tau for u in updates),
            wrong=[u["nodes"] for u, e in zip(updates, errors) if e > problem.list_tolerance(self.row.tau)],
            worst_error=max(errors),
        )


def shown(run: dict) -> str:
    if "failed" in run:
        return "failed: " + run["failed"]
    return f"{run['total']:.2f} s, last {run['last'] * 1e3:.0f} ms, {len(run['wrong'])} lists wrong of {run['updates']}, {run['peak_gb']:.2f} GB"


def main() -> None:
    os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
    args = options()
    import report
    from rows import PRESETS

    rows = [row for row in PRESETS[args.preset]() if all(word in row.name() for word in args.only)]
    if args.peers:
        rows = [replace(row, peers=tuple(args.peers)) for row in rows]
    if args.repeats:
        rows = [replace(row, repeats=args.repeats) for row in rows]
    if args.list:
        print(*(row.name() for row in rows), sep="\n")
        return
    args.work.mkdir(parents=True, exist_ok=True)
    out = args.out or args.work / "result"
    results = []
    for row in rows:
        note(row.name())
        results.append(Comparison(row, args).run())
        report.write(results, out)  # after every row, so that an interrupted run is worth something
    if args.page:
        report.write_into(args.page, results)
    print(report.text(results))


if __name__ == "__main__":
    main()
