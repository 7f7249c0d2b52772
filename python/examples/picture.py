"""Draws what eigentrail knows of a MiniGrid world as an SVG: φ when the goal was first reached and at the end, and eigenvectors.

    python python/examples/picture.py MiniGrid-FourRooms-v0 --steps 3000 -o four_rooms.svg

A walker follows advice. Of all states in a cell (headings, doors, things carried) the cell has the highest φ, and the mean
of an eigenvector. Cells where nobody was are white.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import eigentrail
import gymnasium as gym
import minigrid  # noqa: F401 (registers its worlds)
import numpy as np
from minigrid.wrappers import ReseedWrapper

Cells = dict[tuple[int, int], float]
LEVELS = 24
# From dark to light, and from blue over grey to red.
RISING = [(48, 18, 80), (32, 104, 140), (64, 176, 120), (250, 230, 60)]
SIGNED = [(40, 90, 180), (225, 225, 225), (190, 50, 50)]


def walk(name: str, layout: int, steps: int) -> list[tuple[str, Cells, list[tuple[int, int, int]]]]:
    """Panels: title, value by cell, colours."""
    env = ReseedWrapper(gym.make(name), seeds=(layout,))
    env = eigentrail.Shaped(env, key="minigrid", gamma=0.99, exploration={"potential_advice": 20.0})
    panels = []
    places: dict[int, tuple[int, int]] = {}

    def by_cell(values: np.ndarray, of_cell: Callable[[Any], float]) -> Cells:
        found = defaultdict(list)
        for node, value in enumerate(values):
            if node in places:
                found[places[node]].append(float(value))
        return {place: of_cell(some) for place, some in found.items()}

    _, info = env.reset(seed=0)
    for step in range(1, steps + 1):
        places[info["node"]] = tuple(map(int, env.unwrapped.agent_pos))
        _, _, terminated, truncated, info = env.step(int(info["advice"].argmax()))
        places[info["node"]] = tuple(map(int, env.unwrapped.agent_pos))
        if env.engine.goals() and not panels:
            env.engine.refit()
            panels.append((f"φ at the first goal, step {step}", by_cell(env.engine.potential(), max), RISING))
        if terminated or truncated:
            _, info = env.reset()
    env.engine.refit()
    known = env.engine.num_nodes
    panels.append((f"φ at step {steps}, {known} states", by_cell(env.engine.potential(), max), RISING))
    vectors = env.engine.eigenvectors()
    for i in range(1, min(3, vectors.shape[1])):
        panels.append((f"eigenvector {i}", by_cell(vectors[:, i], np.mean), SIGNED))
    return panels


def colour(share: float, colours: list[tuple[int, int, int]]) -> str:
    place = share * (len(colours) - 1)
    low = min(int(place), len(colours) - 2)
    mixed = np.array(colours[low]) + (place - low) * (np.array(colours[low + 1]) - np.array(colours[low]))
    return "#" + "".join(f"{round(part):02x}" for part in mixed)


def drawn(cells: Cells, colours: list[tuple[int, int, int]], size: float) -> str:
    """The cells of each colour as one path."""
    low, high = min(cells.values()), max(cells.values())
    levels: dict[int, list[str]] = defaultdict(list)
    for (x, y), value in sorted(cells.items()):
        share = (value - low) / (high - low) if high > low else 0.0
        levels[min(int(share * LEVELS), LEVELS - 1)].append(f"M{x} {y}h1v1h-1z")
    paths = (f'<path fill="{colour(level / (LEVELS - 1), colours)}" d="{"".join(some)}"/>' for level, some in levels.items())
    return f'<g transform="scale({size:.3f})">{"".join(paths)}</g>'


def picture(name: str, layout: int, steps: int) -> str:
    panels = walk(name, layout, steps)
    right = max(x for _, cells, _ in panels for x, _ in cells) + 2
    bottom = max(y for _, cells, _ in panels for _, y in cells) + 2
    width, height = 230, 230 * bottom / right
    parts = []
    for i, (title, cells, colours) in enumerate(panels):
        frame = f'<rect width="{width}" height="{height:.0f}" fill="#fff" stroke="#999"/>'
        label = f'<text y="-7" font-size="12">{title}</text>'
        parts.append(f'<g transform="translate({10 + i * (width + 14)} 26)">{label}{frame}{drawn(cells, colours, width / right)}</g>')
    size = (20 + len(panels) * (width + 14) - 14, height + 36)
    style = 'font-family="sans-serif" fill="#333"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size[0]}" height="{size[1]:.0f}" {style}>'
        f'<title>{name}, layout {layout}</title><rect width="100%" height="100%" fill="#f6f6f6"/>{"".join(parts)}</svg>\n'
    )


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("world", help="the id of a MiniGrid world")
    parser.add_argument("--layout", type=int, default=0, help="the seed of its layout")
    parser.add_argument("--steps", type=int, default=3000, help="steps of the walker")
    parser.add_argument("-o", "--out", type=Path, required=True, help="the SVG file")
    asked = parser.parse_args(arguments)
    asked.out.write_text(picture(asked.world, asked.layout, asked.steps), encoding="utf-8")


if __name__ == "__main__":
    main()
