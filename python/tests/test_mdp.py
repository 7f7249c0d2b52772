"""Exact MDPs, against tables that Gymnasium has and against value iteration in NumPy."""

from __future__ import annotations

import eigentrail
import gymnasium as gym
import minigrid  # noqa: F401 (registers its worlds)
import numpy as np
import pytest
from conftest import Corridor
from test_shaped import registered


class Plain(gym.Wrapper):
    """Hides nothing, but keeps the table from being taken."""


def values_of(table, gamma: float, sweeps: int = 20_000) -> np.ndarray:
    values = np.zeros(len(table))
    for _ in range(sweeps):
        best = [
            max(sum(p * (r + gamma * values[s] * (not d)) for p, s, r, d in outcomes) for outcomes in table[state].values())
            for state in range(len(table))
        ]
        change = np.abs(best - values).max()
        values = np.array(best)
        if change < 1e-12:
            break
    return values


@pytest.mark.parametrize(("name", "gamma"), [("FrozenLake-v1", 0.99), ("FrozenLake-v1", 1.0), ("CliffWalking-v1", 1.0), ("Taxi-v4", 0.95)])
def test_tables_are_solved_exactly(name, gamma):
    env = gym.make(registered(name))
    mdp = eigentrail.explore(env)
    assert mdp.complete and mdp.exact and mdp.starts.sum() == pytest.approx(1.0)
    solution = mdp.solve(gamma)
    expected = values_of(env.unwrapped.P, gamma)
    going_on = ~mdp.terminal
    states = np.array(mdp.states)
    np.testing.assert_allclose(solution.values[going_on], expected[states[going_on]], atol=1e-6)
    assert not solution.values[mdp.terminal].any()
    best = env.unwrapped.initial_state_distrib @ expected
    assert mdp.optimal_return == solution.optimal_return == pytest.approx(best, abs=1e-6)


def test_known_optima():
    lake = eigentrail.explore(gym.make("FrozenLake-v1"))
    assert lake.solve(1.0).optimal_return == pytest.approx(14 / 17, abs=1e-6)
    assert eigentrail.explore(gym.make("CliffWalking-v1")).optimal_return == -13


def test_exploring_finds_what_the_table_says():
    for arguments in ({"is_slippery": False}, {"is_slippery": False, "map_name": "8x8"}):
        told = eigentrail.explore(gym.make("FrozenLake-v1", **arguments))
        found = eigentrail.explore(Plain(gym.make("FrozenLake-v1", **arguments)))
        assert found.complete and found.exact

        def ways(mdp):
            columns = (mdp.source, mdp.action, mdp.target, mdp.reward, mdp.ends)
            rows = zip(*(column.tolist() for column in columns), strict=True)
            return {(mdp.states[s], a, mdp.states[t], r, e) for s, a, t, r, e in rows}

        assert ways(found) == ways(told)
        assert found.solve(0.9).optimal_return == pytest.approx(told.solve(0.9).optimal_return)


def test_where_actions_slip_they_are_counted():
    told = eigentrail.explore(gym.make("FrozenLake-v1"))
    found = eigentrail.explore(Plain(gym.make("FrozenLake-v1")), samples=200)
    assert found.complete and not found.exact and found.num_states == told.num_states
    assert len(found.source) == len(told.source)

    def chances(mdp):
        columns = (mdp.source, mdp.action, mdp.target, mdp.ends, mdp.probability)
        rows = zip(*(column.tolist() for column in columns), strict=True)
        return {(mdp.states[s], a, mdp.states[t], e): p for s, a, t, e, p in rows}

    exact, counted = chances(told), chances(found)
    assert exact.keys() == counted.keys()
    assert max(abs(exact[way] - counted[way]) for way in exact) < 0.2
    assert found.solve(0.95).optimal_return == pytest.approx(told.solve(0.95).optimal_return, abs=0.1)


def test_the_policy_is_the_shortest_way_through_a_minigrid_world():
    env = gym.make("MiniGrid-Empty-6x6-v0")
    mdp = eigentrail.explore(env, "minigrid")
    assert mdp.complete and mdp.num_states == 4 * 16 - 2
    assert len(set(mdp.reward[mdp.ends])) == 1, "the clock is stopped"
    solution = mdp.solve(gamma=0.9)
    env.reset(seed=0)
    namer = eigentrail.keys.Namer("minigrid")
    namer.reset(env)
    for step in range(1, 9):
        _, _, terminated, _, _ = env.step(solution.policy(namer.state(env, None)))
        assert terminated == (step == 7), "three on, a turn, three on"
        if terminated:
            break
    assert mdp.policy(namer.state(env, None)) is None


def test_a_search_that_was_cut_short_says_so():
    mdp = eigentrail.explore(Plain(gym.make("FrozenLake-v1", map_name="8x8")), max_steps=50)
    assert not mdp.complete and "not complete" in repr(mdp)
    with pytest.raises(ValueError, match="explore with more max_steps"):
        mdp.solve()


def test_what_the_step_limit_puts_out_of_reach_is_given_up():
    mdp = eigentrail.explore(Corridor(length=50, limit=10), max_steps=5000)
    assert not mdp.complete and mdp.num_states == 11


def test_rewards_that_change_are_warned_of():
    class Fading(Corridor):
        def step(self, action):
            room, reward, *rest = super().step(action)
            return room, reward * self.age, *rest

    with pytest.warns(UserWarning, match="paid now more and now less"):
        eigentrail.explore(Fading())


def test_values_that_grow_without_end_are_refused():
    class Fountain(Corridor):
        def step(self, action):
            room, _, terminated, truncated, info = super().step(action)
            return room, 1.0, terminated, truncated, info

    mdp = eigentrail.explore(Fountain())
    with pytest.raises(ValueError, match="some loop pays for ever; choose a smaller gamma"):
        mdp.solve(gamma=1.0)
    assert mdp.solve(gamma=0.5).values.max() == pytest.approx(2.0, rel=0.01)
    with pytest.raises(ValueError, match="gamma = 1.5: must be within 0 and 1"):
        mdp.solve(gamma=1.5)


@pytest.mark.parametrize("name", ["FrozenLake-v1", "CliffWalking-v1"])
def test_a_potential_that_is_zero_at_ends_keeps_all_optimal_actions(name, rng):
    mdp = eigentrail.explore(gym.make(name))
    for gamma in (0.9, 0.99):
        phi = rng.normal(size=mdp.num_states) * 10
        phi[np.unique(mdp.target[mdp.ends])] = 0.0
        check = eigentrail.check_shaping(mdp, phi, gamma)
        assert check.kept and bool(check) and check.reasons == []
        assert len(check.states) == (~mdp.terminal).sum()
    q = mdp.solve(0.99).q
    for state in check.states:
        row = q[mdp.number_of(state.state)]
        assert state.before == state.after == np.flatnonzero(row >= row.max() - 1e-6 * np.abs(q).max(initial=1)).tolist()


def test_faults_of_a_potential_are_found(rng):
    mdp = eigentrail.explore(gym.make("FrozenLake-v1", is_slippery=False))
    hole = eigentrail.check_shaping(mdp, {state: 5.0 if state == 12 else 0.0 for state in mdp.states}, 0.9)
    assert not hole and {row.state for row in hole.changed} and "φ is not 0 at 1 of 5" in str(hole)
    other = eigentrail.check_shaping(mdp, lambda state: float(-state if state in (1, 2, 6) else 0), 0.9, shaping_gamma=0.3)
    assert "shaping discounts by 0.3, the learner by 0.9" in other.reasons
    with pytest.raises(ValueError, match="phi has shape"):
        eigentrail.check_shaping(mdp, [1.0, 2.0], 0.9)
    with pytest.raises(ValueError, match="phi is not finite everywhere"):
        eigentrail.check_shaping(mdp, np.full(mdp.num_states, np.nan), 0.9)


def test_the_engine_keeps_optimal_actions(rng):
    env = eigentrail.Shaped(gym.make("FrozenLake-v1", is_slippery=False), gamma=0.9, exploration={"potential_advice": 20.0})
    _, info = env.reset(seed=0)
    for _ in range(1000):
        _, _, terminated, truncated, info = env.step(int(info["advice"].argmax()))
        if terminated or truncated:
            _, info = env.reset()
    assert env.engine.potential().any()
    mdp = eigentrail.explore(gym.make("FrozenLake-v1", is_slippery=False))
    assert eigentrail.check_shaping(mdp, env, 0.9).kept
    assert eigentrail.check_shaping(mdp, env.engine, 0.9).kept
