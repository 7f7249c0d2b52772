"""A policy that takes advice: π(a | s) ∝ exp(logits(s, a) + advice(s, a))."""

from __future__ import annotations

from typing import Any

import torch
from gymnasium import spaces
from stable_baselines3.common.distributions import Distribution
from stable_baselines3.common.policies import MultiInputActorCriticPolicy
from stable_baselines3.common.torch_layers import CombinedExtractor


class _WithoutAdvice(CombinedExtractor):
    """All of the observation but the advice, which no network is to rely on."""

    def __init__(self, observation_space: spaces.Dict, **arguments: Any) -> None:
        parts = {name: part for name, part in observation_space.spaces.items() if name != "advice"}
        super().__init__(spaces.Dict(parts), **arguments)


class AdvisedPolicy(MultiInputActorCriticPolicy):
    """An actor-critic for observations with an entry ``"advice"``, which is added to its logits; for PPO and A2C.

    Advice is part of what was observed when an action was chosen, and is kept with it: the probabilities that the learner
    compares are those by which the actions were drawn, and the update stays the one of the paper. The networks do
    not see it. Without ``eigentrail`` around the environment, an ``"advice"`` of zeros leaves the policy that was learnt.
    """

    def __init__(self, observation_space: spaces.Space, *arguments: Any, **named: Any) -> None:
        if not isinstance(observation_space, spaces.Dict) or "advice" not in observation_space.spaces:
            raise ValueError('observations have no entry "advice": wrap with ShapedVecEnv(…, advice=True)')
        named.setdefault("features_extractor_class", _WithoutAdvice)
        super().__init__(observation_space, *arguments, **named)

    def forward(self, obs: Any, deterministic: bool = False) -> Any:
        """Actions, values and log-probabilities."""
        self._advice = obs["advice"]
        return super().forward(obs, deterministic)

    def evaluate_actions(self, obs: Any, actions: torch.Tensor) -> Any:
        """Values, and log-probabilities of these actions."""
        self._advice = obs["advice"]
        return super().evaluate_actions(obs, actions)

    def get_distribution(self, obs: Any) -> Distribution:
        """The distribution of actions."""
        self._advice = obs["advice"]
        return super().get_distribution(obs)

    def _get_action_dist_from_latent(self, latent_pi: torch.Tensor) -> Distribution:
        logits = self.action_net(latent_pi) + self._advice
        return self.action_dist.proba_distribution(action_logits=logits)
