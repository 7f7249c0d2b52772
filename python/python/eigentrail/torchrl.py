"""TorchRL: a transform that shapes rewards.

>>> from torchrl.envs import GymEnv, TransformedEnv
>>> from eigentrail.torchrl import Shaping
>>> env = TransformedEnv(GymEnv("FrozenLake-v1", is_slippery=False), Shaping(key="obs", gamma=0.99))
>>> rollout = env.rollout(20, break_when_any_done=False)
>>> rollout["next", "advice"].shape, env.transform.engine.steps
(torch.Size([20, 4]), 20)
"""

from __future__ import annotations

from typing import Any

import numpy as np

try:
    import torch
    from tensordict import TensorDictBase
    from torchrl.data import OneHot, Unbounded
    from torchrl.envs.transforms import Transform
except ModuleNotFoundError as error:
    if error.name not in ("torch", "torchrl", "tensordict"):
        raise
    raise ImportError("eigentrail.torchrl needs TorchRL: pip install eigentrail[torchrl]") from error

from .engine import Engine
from .keys import KeyLike, Namer
from .walkers import Walkers
from .worlds import require_choice


class Shaping(Transform):
    """Rewards shaped by what was discovered so far: R′ = R + γ φ(s′) − φ(s). All environments of a batch share what they find.

    Parameters are those of :class:`eigentrail.Shaped`; ``observation`` is the entry that the key ``"obs"`` names states by. Keys that
    look into environments need those of a ``GymEnv``, or of a ``SerialEnv`` of them. Entries ``extrinsic_reward``,
    ``shaping``, ``phi`` and ``advice`` come with every step and reset: ``advice`` belongs to the state it comes with.

    For environments with one agent, whose batch has at most one dimension.
    """

    invertible = False

    def __init__(
        self,
        key: KeyLike = "obs",
        gamma: float = 0.99,
        *,
        reward: str = "shaped",
        observation: str = "observation",
        seed: int = 0,
        max_layouts: int = 64,
        **params: dict[str, Any],
    ) -> None:
        require_choice("reward", reward, ("shaped", "raw"))
        super().__init__()
        self.gamma = gamma
        self._key = key
        self._returns_shaped = reward == "shaped"
        self._observation = observation
        self._made_of = (gamma, seed, max_layouts, params)
        self._state: tuple[Walkers, list[Namer], bool] | None = None

    @property
    def engine(self) -> Engine:
        """The engine of the layout in which an episode was begun last; of worlds with one layout, the only one."""
        return self._made()[0].worlds.first

    @property
    def engines(self) -> list[Engine]:
        """Of each environment, the engine of its layout."""
        return list(self._made()[0].engines)

    def _made(self) -> tuple[Walkers, list[Namer], bool]:
        """Walkers, their namers, and whether actions are one-hot. They are made when the environment is known."""
        if self._state is None:
            env = self.parent
            if env is None:
                raise RuntimeError("Shaping is no part of an environment yet: TransformedEnv(env, Shaping(…))")
            if len(env.batch_size) > 1:
                raise ValueError(f"a batch of the shape {tuple(env.batch_size)}: one dimension at most")
            spec = env.action_spec_unbatched
            if not hasattr(spec, "space") or not hasattr(spec.space, "n"):
                raise TypeError(f"the action space is {spec}: eigentrail needs finitely many actions")
            number = env.batch_size.numel()
            gamma, seed, max_layouts, params = self._made_of
            walkers = Walkers(number, (int(spec.space.n), 0), gamma, seed, max_layouts, params)
            namers = [Namer(self._key) for _ in range(number)]
            if namers[0].needs_env:
                self._inside(number)
            self._state = walkers, namers, isinstance(spec, OneHot)
        return self._state

    def _inside(self, number: int) -> list[Any]:
        """The Gymnasium environments."""
        base = self.parent.base_env
        # Environments elsewhere are asked for every attribute that is not there: look at what is.
        members = vars(base).get("_envs") or [base]
        found = [vars(member).get("_env") for member in members]
        if len(found) != number or not all(hasattr(env, "unwrapped") for env in found):
            raise TypeError(
                f"the key has to look into the environments of {type(base).__name__}, which it cannot: use "
                '"obs", a GymEnv, or a SerialEnv of them'
            )
        return found

    def _places(self) -> list[Any]:
        walkers, namers, _ = self._made()
        return self._inside(len(namers)) if namers[0].needs_env else [None] * len(namers)

    def _name(self, i: int, env: Any, observations: np.ndarray) -> bytes:
        return self._made()[1][i](env, observations[i])

    def _observations(self, tensordict: TensorDictBase) -> np.ndarray:
        """What was observed, one row for each environment."""
        _, namers, _ = self._made()
        if namers[0].needs_env:
            return np.empty((len(namers), 0))
        value = tensordict.get(self._observation)
        if value is None:
            raise KeyError(f'there is no entry "{self._observation}" to name states by: give another observation')
        value = value.detach().cpu().numpy()
        return value if tensordict.batch_size else value[None]

    def _reset(self, tensordict: TensorDictBase, tensordict_reset: TensorDictBase) -> TensorDictBase:
        walkers, namers, _ = self._made()
        mask = None if tensordict is None else tensordict.get("_reset", None)
        begun = [True] * len(namers) if mask is None else mask.reshape(-1).tolist()
        observations = self._observations(tensordict_reset)
        for i, env in enumerate(self._places()):
            if begun[i]:
                layout = namers[i].reset(env)
                walkers.begin(i, layout, self._name(i, env, observations))
        zeros = np.zeros(len(namers))
        self._tell(tensordict_reset, zeros, zeros, walkers.phi(walkers.nodes()))
        return tensordict_reset

    def _step(self, tensordict: TensorDictBase, next_tensordict: TensorDictBase) -> TensorDictBase:
        walkers, namers, one_hot = self._made()
        number = len(namers)
        actions = tensordict.get(self.parent.action_key)
        actions = (actions.argmax(-1) if one_hot else actions).reshape(number).tolist()
        rewards = next_tensordict.get(self.parent.reward_key)
        raw = rewards.detach().cpu().reshape(number).double().numpy()
        ends = [self._flags(next_tensordict, name, number) for name in ("terminated", "truncated")]
        steps = self._flags(tensordict, "_step", number, missing=True)
        observations = self._observations(next_tensordict)
        shaping, bonus, phi = np.zeros(number), np.zeros(number), np.zeros(number)
        for i, env in enumerate(self._places()):
            if steps[i]:
                name = self._name(i, env, observations)
                seen = walkers.observe(i, actions[i], name, raw[i], ends[0][i], ends[1][i])
                shaping[i], bonus[i], phi[i] = seen.shaping, seen.bonus, seen.phi
        self._tell(next_tensordict, raw, shaping, phi)
        if self._returns_shaped:
            shaped = torch.as_tensor(raw + shaping + bonus, dtype=rewards.dtype, device=rewards.device)
            next_tensordict.set(self.parent.reward_key, shaped.reshape(rewards.shape))
        return next_tensordict

    def _flags(self, tensordict: TensorDictBase, name: str, number: int, missing: bool = False) -> list[bool]:
        value = tensordict.get(name, None)
        return [missing] * number if value is None else value.reshape(number).tolist()

    def _tell(self, tensordict: TensorDictBase, raw: np.ndarray, shaping: np.ndarray, phi: np.ndarray) -> None:
        batch = tensordict.batch_size
        advice = self._made()[0].advice()
        for name, column in (("extrinsic_reward", raw), ("shaping", shaping), ("phi", phi), ("advice", advice)):
            value = torch.as_tensor(column, dtype=torch.float32, device=tensordict.device)
            tensordict.set(name, value.reshape(*batch, -1))

    def transform_observation_spec(self, observation_spec: Any) -> Any:
        """With the entries that come with every step and reset."""
        batch = observation_spec.shape
        widths = {"extrinsic_reward": 1, "shaping": 1, "phi": 1, "advice": self.engine.num_actions}
        for name, width in widths.items():
            observation_spec[name] = Unbounded((*batch, width), device=observation_spec.device)
        return observation_spec
