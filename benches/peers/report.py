"""Ratios ours ÷ best peer with their spread: as text, Markdown and JSON."""

import json
import os
import platform
import statistics
import time
from pathlib import Path

BEGIN, END = "<!-- results -->", "<!-- end of results -->"

HEAD = ("row", "ours", "best peer", "ours ÷ peer, whole", "last updates", "peak GB", "lists wrong: ours / peers", "worst error of λ ÷ λ_k")


def write(results: list[dict], out: Path) -> None:
    out.parent.mkdir(parents=True, exist_ok=True)
    facts = dict(machine=machine(), results=results)
    out.with_suffix(".json").write_text(json.dumps(facts, indent=1))
    out.with_suffix(".md").write_text(markdown(results) + "\n")
    out.with_suffix(".txt").write_text(text(results) + "\n")


def write_into(page: Path, results: list[dict]) -> None:
    """Replaces what stands between the page's markers."""
    before, rest = page.read_text().split(BEGIN)
    after = rest.split(END)[1]
    page.write_text(f"{before}{BEGIN}\n\n{markdown(results)}\n\n{END}{after}")


def machine() -> dict:
    model = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "?")
    load = " ".join(f"{x:.1f}" for x in os.getloadavg())
    return dict(processor=model, cores=os.cpu_count(), system=platform.platform(), load=load, time=time.strftime("%Y-%m-%d %H:%M"))


def cells(result: dict) -> list[str]:
    row, runs = result["row"], result["runs"]
    label = row_label(row)
    sound = {name: good for name, some in runs.items() if (good := [r for r in some if "failed" not in r])}
    ours, peers = sound.pop("eigentrail", None), sound
    if not ours or not peers:
        return [label, *["failed"] * (len(HEAD) - 1)]
    whole = row["kind"] == "sequence"
    measure = "total" if whole else "last"
    best = min(peers, key=lambda name: middle(peers[name], measure))
    best_last = min(peers, key=lambda name: middle(peers[name], "last"))
    return [
        label,
        seconds(middle(ours, measure)),
        f"{seconds(middle(peers[best], measure))} {best}",
        spread(ours, peers[best], "total") if whole else "–",
        spread(ours, peers[best_last], "last"),
        f"{peak(ours):.2f} / {peak(peers[best]):.2f}",
        " / ".join([wrong(ours), *(f"{wrong(peers[name])} {name}" for name in peers)]),
        " / ".join(f"{max(r['worst_error'] for r in some):.0e}" for some in (ours, peers[best])),
    ]


def row_label(row: dict) -> str:
    cores = "1 thread, CPU" if row["threads"] == 1 else f"{row['threads']} threads, wall"
    what = "64 → " if row["kind"] == "sequence" else "one update at "
    return f"{what}{row['size']} {row['family']}, {row['order']}, k = {row['k']}, τ = {row['tau']:g}, {cores}"


def middle(runs: list[dict], measure: str) -> float:
    return statistics.median(r[measure] for r in runs)


def spread(ours: list[dict], peer: list[dict], measure: str) -> str:
    """Median [least, largest] of the ratios within a round."""
    ratios = sorted(a[measure] / b[measure] for a, b in zip(ours, peer))
    return f"{statistics.median(ratios):.2f} [{ratios[0]:.2f}, {ratios[-1]:.2f}]"


def seconds(value: float) -> str:
    return f"{value:.2f} s" if value >= 1 else f"{value * 1e3:.0f} ms"


def peak(runs: list[dict]) -> float:
    return max(r["peak_gb"] for r in runs)


def wrong(runs: list[dict]) -> str:
    """Updates whose list was wrong, of all; `late` ones missed the residual."""
    late = sum(r["late"] for r in runs)
    count = f"{sum(len(r['wrong']) for r in runs)}/{sum(r['updates'] for r in runs)}"
    return f"{count} ({late} late)" if late else count


def text(results: list[dict]) -> str:
    table = [list(HEAD), *(cells(r) for r in results)]
    widths = [max(len(line[c]) for line in table) for c in range(len(HEAD))]
    return "\n".join("  ".join(cell.ljust(w) for cell, w in zip(line, widths)).rstrip() for line in table)


def markdown(results: list[dict]) -> str:
    lines = ["| " + " | ".join(HEAD) + " |", "|---" * len(HEAD) + "|"]
    facts = machine()
    lines += ["| " + " | ".join(cells(r)) + " |" for r in results]
    return "\n".join([f"{facts['processor']}, {facts['cores']} cores, {facts['system']}, {facts['time']}, load {facts['load']}.", "", *lines])
