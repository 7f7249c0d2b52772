"""Rows of a board as a CSV file, each written as soon as it is known; a board that is run again goes on where it stopped."""

import argparse
import csv
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Rows:
    """The rows of OUT/NAME.csv. The first `num_names` columns are what was measured, the others what came of it."""

    def __init__(self, folder, name, columns, num_names):
        self.path = pathlib.Path(folder) / f"{name}.csv"
        self.columns = [*columns, "commit"]
        self.num_names = num_names
        self.path.parent.mkdir(parents=True, exist_ok=True)
        if not self.path.exists():
            self._append(self.columns)
        self._done = {tuple(row[c] for c in columns[:num_names]) for row in read(self.path)}
        self._commit = commit()

    def lacks(self, *names):
        """Whether this is still to be measured."""
        return tuple(map(str, names)) not in self._done

    def add(self, *values):
        print(*values, sep="\t", flush=True)
        self._append([*values, self._commit])

    def _append(self, values):
        with open(self.path, "a", newline="") as file:
            csv.writer(file, lineterminator="\n").writerow("" if value is None else value for value in values)


def read(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def commit():
    """The commit that is measured; one with a plus where files differ from it."""
    told = ["git", "-C", str(ROOT), "describe", "--always", "--abbrev=7", "--exclude=*", "--dirty=+"]
    return subprocess.run(told, check=True, capture_output=True, text=True).stdout.strip()


def arguments(text, **options):
    """The folder of results, and what else a board takes."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", help="folder of results")
    for name, (kind, default, told) in options.items():
        parser.add_argument(f"--{name}", type=kind, default=default, help=f"{told} (default: {default})")
    return parser.parse_args()
