"""Scenarios from Python: the documents of the program, its errors, its folders."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import eigentrail
import numpy as np
import pytest
from eigentrail import _eigentrail
from eigentrail.experiments import toml

SHORT = {"run.episodes": 30}
LONG = {"run.episodes": 100_000_000}
GRID = {"shaping.potential": ["gcn", "heat"], "env.slip": [0.0, 0.1]}


def text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def test_one_seed_is_one_document_and_several_are_a_list(tmp_path):
    one = eigentrail.run("smoke", seeds=np.int64(3), set=SHORT, out=tmp_path / "one")
    several = eigentrail.run("smoke", seeds=[3, 4, 3], set=SHORT)
    clock = {"wall_seconds", "steps_per_second"}
    assert list(several) == ["scenario", "seeds"]
    assert [seed["seed"] for seed in several["seeds"]] == [3, 4]
    assert {k: v for k, v in one.items() if k not in clock} == {
        k: v for k, v in several["seeds"][0].items() if k not in clock
    }
    summary = json.loads(text(tmp_path / "one" / "summary.json"))["seeds"][0]
    assert all(one[name] == summary[name] for name in ("steps", "regret", "nodes", "first_goal_step"))
    assert eigentrail.run("smoke", set=SHORT | {"run.seed": 7})["seed"] == 7


def test_a_run_goes_on_in_its_folder(tmp_path):
    first = eigentrail.run("smoke", seeds=[0], set=SHORT, out=tmp_path / "o")
    again = eigentrail.run("smoke", seeds=range(2), set=SHORT, out=tmp_path / "o")
    assert again["seeds"][0] == first["seeds"][0], "clock and all: it was not run again"
    with pytest.raises(ValueError, match="cannot resume: the scenario differs"):
        eigentrail.run("smoke", seeds=[0], set={"run.episodes": 31}, out=tmp_path / "o")


def test_a_comparison_is_what_its_folder_holds(tmp_path):
    compared = eigentrail.compare("smoke", arms=["sparse", "gcn"], seeds=range(3), set=SHORT, out=tmp_path / "o")
    assert compared == json.loads(text(tmp_path / "o" / "compare.json"))
    assert [arm["name"] for arm in compared["arms"]] == ["sparse", "gcn"]
    frame = compared.to_pandas()
    assert list(frame["name"]) == ["sparse", "gcn"]
    assert frame["regret.iqm"][1] == compared["arms"][1]["regret"]["iqm"]


def test_a_sweep_is_what_its_folder_holds(tmp_path):
    out = tmp_path / "o"
    swept = eigentrail.sweep("smoke", GRID, seeds=range(3), set=SHORT, out=out, threads=1)
    assert swept == json.loads(text(out / "summary.json"))
    assert swept == eigentrail.sweep("smoke", GRID, seeds=range(3), set=SHORT, threads=3)
    points = swept.to_pandas()
    assert list(points["env.slip"]) == [0.0, 0.1, 0.0, 0.1]
    trials = swept.trials_to_pandas()
    assert len(trials) == 12 and trials["regret"].dtype == float
    assert list(trials.columns[:4]) == ["shaping.potential", "env.slip", "seed", "episodes"]
    point = trials[(trials["shaping.potential"] == "heat") & (trials["env.slip"] == 0.1)]
    assert point.loc[point["regret"].idxmax(), "seed"] == swept["points"][3]["worst_seed"]
    with_arms = eigentrail.sweep("smoke", {"env.slip": [0.1]}, seeds=[1], arms="sparse", set=SHORT)
    assert with_arms.trials[0]["arm"] == "sparse" and with_arms.trials[0]["env.slip"] == 0.1


def test_a_scenario_file_may_be_anywhere(tmp_path):
    (tmp_path / "w.csv").write_text("from,action,to\na,go,b\nb,go,end\n")
    file = tmp_path / "mine.toml"
    file.write_text("[env]\nkind = 'edge-list'\nfile = 'w.csv'\ngoals = [{ at = 'end' }]\n[run]\nepisodes = 5\n")
    result = eigentrail.run(file)
    assert (result["scenario"], result["optimal_steps"]) == ("mine", 2.0)


def test_errors_have_the_text_of_the_program():
    def refuses(words, call):
        with pytest.raises(ValueError, match=re.escape(words)):
            call()

    run, sweep, compare = eigentrail.run, eigentrail.sweep, eigentrail.compare
    refuses("--set agent.gama=1: unknown key `agent.gama`; did you mean `gamma`?", lambda: run("smoke", set={"agent.gama": 1}))
    refuses('--set agent.kind="sarssa": ', lambda: run("smoke", set={"agent.kind": "sarssa"}))
    refuses("--grid agent.gama=0.9: unknown key", lambda: sweep("smoke", {"agent.gama": [0.9]}))
    refuses("there is no arm `plannner`; did you mean `planner`?", lambda: compare("smoke", arms=["plannner"]))
    refuses("there is no such file", lambda: run("no-such-thing.toml"))
    refuses("seeds: there are none", lambda: sweep("smoke", seeds=[]))
    refuses("arms: there are none", lambda: compare("smoke", arms=[]))
    with pytest.raises(TypeError, match="expected a list of values"):
        sweep("smoke", {"agent.kind": "sarsa"})
    with pytest.raises(OverflowError):
        run("smoke", seeds=[-1])


def test_values_are_written_as_toml():
    assert toml('a "b"\n\\') == '"a \\"b\\"\\n\\\\"'
    assert toml([True, 1, 0.5, float("inf")]) == "[true, 1, 0.5, inf]"
    assert toml(np.array([3, 5])) == "[3, 5]" and toml(np.float64(0.25)) == "0.25"
    assert toml(Path("a/b")) == '"a/b"'
    with pytest.raises(TypeError, match="NoneType"):
        toml(None)


def test_progress_is_shown_where_it_is_asked_for(capfd):
    eigentrail.sweep("smoke", seeds=range(3), set=SHORT)
    assert capfd.readouterr().err == "", "stderr is no terminal here"
    eigentrail.sweep("smoke", seeds=range(3), set=SHORT, progress=True)
    assert "3/3" in capfd.readouterr().err


def test_other_threads_go_on():
    began, counted = threading.Event(), 0

    def work():
        began.set()
        eigentrail.run("four_rooms", set={"run.episodes": 3000}, seeds=range(4))

    thread = threading.Thread(target=work)
    thread.start()
    began.wait()
    while thread.is_alive():
        counted += 1
        time.sleep(0.001)
    assert counted > 10


# A shell's background jobs are deaf to Ctrl-C, and so is what they start.
SCRIPT = """
import eigentrail, signal
signal.signal(signal.SIGINT, signal.default_int_handler)
try:
    {call}
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_ctrl_c_keeps_what_is_finished(tmp_path):
    out = tmp_path / "o"
    # The second point has no end: all that can be finished is the first one.
    call = f"eigentrail.sweep('smoke', {{'run.episodes': [30, 100_000_000]}}, seeds=range(2), threads=2, out={str(out)!r})"
    process = subprocess.Popen([sys.executable, "-c", SCRIPT.format(call=call)], stdout=subprocess.PIPE, text=True)
    while len(list(out.glob("points/*/seed-*.json"))) < 2:
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate()
    assert said == "interrupted\n" and process.returncode == 0
    kept = {path: path.stat().st_mtime_ns for path in out.glob("points/*/seed-*.json")}
    assert len(kept) == 2 and not (out / "summary.json").exists()
    swept = eigentrail.sweep("smoke", {"run.episodes": [30]}, seeds=range(2), out=out)
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    assert swept == eigentrail.sweep("smoke", {"run.episodes": [30]}, seeds=range(2))


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize("call", [f"eigentrail.run('smoke', set={LONG})", f"eigentrail.compare('smoke', set={LONG})"])
def test_ctrl_c_ends_any_call(call):
    script = "import os, signal, threading\nthreading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
    process = subprocess.run([sys.executable, "-c", script + SCRIPT.format(call=call)], stdout=subprocess.PIPE, text=True)
    assert process.stdout == "interrupted\n"


def test_shards_from_anywhere_come_to_the_same_bytes(tmp_path):
    there = tmp_path / "there"
    eigentrail.sweep("smoke", GRID, seeds=range(4), set=SHORT, out=tmp_path / "here")
    axes = [("shaping.potential", ['"gcn"', '"heat"']), ("env.slip", ["0.0", "0.1"])]
    folder = _eigentrail.SweepFolder("smoke", ["run.episodes=30"], axes, [], [0, 1, 2, 3], str(there), [])
    assert (folder.was_begun, folder.num_finished, folder.num_trials) == (False, 0, 16)
    assert folder.finish() is None
    for point, seeds in reversed(folder.unfinished()):
        task, _ = folder.task(point)
        for chunk in (seeds[1:], seeds[:1]):
            shard = _eigentrail.run_shard(task, chunk, 1)
            folder.put(shard)
            folder.put(shard)
    assert folder.finish() is not None and folder.unfinished() == []
    for name in ("summary.json", "sweep.csv"):
        assert text(there / name) == text(tmp_path / "here" / name), name
    with pytest.raises(ValueError, match="shard: "):
        folder.put("{")
    with pytest.raises(ValueError, match="another run is writing to this folder"):
        eigentrail.sweep("smoke", GRID, seeds=range(4), set=SHORT, out=there)
    with pytest.raises(IndexError):
        folder.task(4)


def test_ray_is_asked_for_by_name():
    assert callable(eigentrail.ray.sweep)
    try:
        import ray  # noqa: F401
    except ModuleNotFoundError:
        with pytest.raises(ImportError, match=re.escape("pip install eigentrail[ray]")):
            eigentrail.ray.sweep("smoke", seeds=[0])
