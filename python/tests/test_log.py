"""Events of the Rust half in Python's logging."""

from __future__ import annotations

import logging
import threading

import eigentrail
from conftest import Corridor


def explored(steps: int = 200) -> eigentrail.Engine:
    env = eigentrail.Shaped(Corridor(), gamma=1.0)
    _, info = env.reset(seed=0)
    for _ in range(steps):
        _, _, terminated, truncated, info = env.step(int(info["advice"].argmax()))
        if terminated or truncated:
            _, info = env.reset()
    return env.engine


def test_goals_and_refreshes_are_logged(caplog):
    with caplog.at_level(logging.DEBUG, logger="eigentrail"):
        explored()
    told = {record.getMessage().split()[0]: record for record in caplog.records}
    assert {"first_goal", "spectrum_refresh", "gcn_fit", "graph_growth"} <= set(told)
    assert told["first_goal"].levelno == logging.INFO and told["gcn_fit"].levelno == logging.DEBUG
    assert told["first_goal"].fields == {"step": 8, "nodes": 9}
    assert told["first_goal"].getMessage() == "first_goal step=8 nodes=9"
    assert isinstance(told["gcn_fit"].fields["loss"], float) and isinstance(told["gcn_fit"].fields["nodes"], int)
    assert all(record.name == "eigentrail" for record in caplog.records)


def test_a_level_may_change_at_any_time(caplog):
    with caplog.at_level(logging.INFO, logger="eigentrail"):
        explored()
        assert [record.getMessage().split()[0] for record in caplog.records] == ["first_goal"]
    caplog.clear()
    with caplog.at_level(logging.WARNING, logger="eigentrail"):
        explored()
    assert not caplog.records


def test_a_refit_is_logged(caplog):
    engine = explored()
    with caplog.at_level(logging.DEBUG, logger="eigentrail"):
        engine.refit()
    assert "gcn_fit" in caplog.text


def test_the_built_in_agent_is_logged(caplog):
    with caplog.at_level(logging.INFO, logger="eigentrail"):
        result = eigentrail.train(Corridor(), max_steps=200)
    (record,) = [record for record in caplog.records if record.getMessage().startswith("first_goal")]
    assert record.fields["step"] == result.first_goal_step


def test_nobody_waits_for_the_lock_while_threads_log(caplog):
    with caplog.at_level(logging.DEBUG, logger="eigentrail"):
        threads = [threading.Thread(target=explored) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60)
    assert not any(thread.is_alive() for thread in threads)
    assert sum(record.getMessage().startswith("first_goal") for record in caplog.records) == 4
