"""Time of a step on many ranks, from what was measured on few: a table and a picture of the strong efficiency.

    python run_scripts/studies/cost_model/model.py -o studies/cost_model
    python run_scripts/studies/cost_model/model.py --latency 3 --bandwidth 1 -o studies/cost_model

Reads measured/: partitions.csv (partitions.py), and in 2D and 3D phases_2d.json (phases.py), messages_2d.json
(messages.py) and multigrid_2d.json (multigrid.py). The assumptions are in the README of the studies.
"""

import argparse
import csv
import json
import sys
from dataclasses import dataclass
from math import ceil, log2, log10, pi
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))

from parisph.base import markdown  # noqa: E402

MEASURED = Path(__file__).with_name("measured")
PUBLISHED = (6144, 0.43)    # ranks and efficiency of all of an ISPH code (Guo et al. 2018), another scene and machine
DOUBLE = 8                  # bytes
COARSEST = 9                # rows of a level that hypre does not coarsen any more
GATHERS = 6                 # arrays of a number for each rank that a step exchanges: layouts of PETSc, pressure.groups
PARTS = ("particles", "Python", "ghosts", "iterations", "sums", "set-up", "marks")


@dataclass(frozen=True)
class Network:
    """latency : of a message [s]; bandwidth : of a rank [bytes/s]."""

    latency: float
    bandwidth: float

    def exchange(self, neighbours: float, size: float) -> float:
        """Return the time [s] of messages to some neighbours, of `size` bytes together."""
        return neighbours * self.latency + size / self.bandwidth

    def together(self, ranks: int) -> float:
        """Return the time [s] of a sum over the ranks."""
        return ceil(log2(ranks)) * self.latency if ranks > 1 else 0.0


@dataclass(frozen=True)
class Measured:
    """What was measured in 2D or in 3D; see README.

    phases, messages, grids : contents of the files; messages on two ranks
    """

    phases: dict
    messages: dict
    grids: list[dict]

    @classmethod
    def read(cls, folder: Path) -> "dict[int, Measured]":
        """Read the files of a folder; return what was measured by dimension."""
        def contents(name, dim):
            return json.loads((folder / f"{name}_{dim}d.json").read_text(encoding="utf-8"))

        return {dim: cls(contents("phases", dim), next(one for one in contents("messages", dim) if one["ranks"] == 2),
                         contents("multigrid", dim)) for dim in (2, 3)}

    def counts(self, name: str) -> list[float]:
        """Return sends, bytes and collectives on two ranks: rounds of exchanges of one neighbour."""
        return self.messages["counts"][name]

    def levels(self, unknowns: float) -> list[tuple[float, float]]:
        """Return (rows, entries of a row) of all levels: shares of rows as in the largest measured grid, then fewer."""
        grid = self.grids[-1]
        found = [(unknowns * level["rows"] / grid["unknowns"], level["entries"] / level["rows"])
                 for level in grid["levels"]]
        shrinks = found[-3][0] / found[-2][0]
        found = found[:1] + [level for before, level in zip(found, found[1:]) if before[0] > COARSEST]
        while found[-1][0] > COARSEST:
            found.append((found[-1][0] / shrinks, min(found[-2][1], found[-1][0] / shrinks)))
        return found


def step(measured: Measured, network: Network, line: dict[str, float]) -> dict[str, float]:
    """Return the times [s] of the parts of a step, by PARTS, on the ranks of a line of partitions.csv."""
    m, ranks = measured.phases, int(line["ranks"])
    together = network.together(ranks)
    particles = m["us_all"] * line["owned_max"] + m["lists"] * m["us_ghost"] * line["halo_received_max"]
    found = {"particles": 1e-6 * particles, "Python": 1e-3 * m["overhead_ms"]}
    if ranks == 1:
        return {**dict.fromkeys(PARTS, 0.0), **found}
    counted, size, _ = measured.counts("step/updates")
    size *= m["updates"] / counted * line["halo_received_max"] / measured.messages["ghosts"]
    found["ghosts"] = network.exchange(m["updates"] * line["halo_to_max"], size)
    # particles that change rank: every plan sends the ghosts anew and asks everyone
    plan = measured.counts("plan")
    found["ghosts"] += m["plans"] * (
        network.exchange(plan[0] * line["halo_to_max"], plan[1] * line["halo_received_max"]
                         / measured.messages["ghosts"]) + plan[2] * together + 2 * DOUBLE * ranks / network.bandwidth)
    iterations = m["iterations"] + m["position_iterations"]
    found["iterations"] = iterations * (_product(network, line) + _cycle(measured, network, line))
    found["sums"] = (iterations * _sums_of_iteration(measured) + _other_sums(measured)) * together
    found["sums"] += GATHERS * DOUBLE * ranks / network.bandwidth
    found["set-up"] = _other_rounds(measured) * _product(network, line) + m["built"] * _set_up(measured, network, line)
    found["marks"] = (line["hops"] + 1.0) * (line["matrix_to_max"] * network.latency + together)
    return found


def _product(network, line):
    """Time of the exchange of a product with the matrix."""
    return network.exchange(line["matrix_to_max"], DOUBLE * line["matrix_received_max"])


def _neighbours(line, rows, row):
    """Ranks that one exchanges with on a level, of a number of rows of so many entries.

    A rank has a cube of the level; the stencil, a ball, reaches some of its spacings farther. At least as many as on
    the finest level, at most as many as the row has entries or as there are rows, when ranks have one or none.
    """
    ranks, dim = line["ranks"], int(line["dim"])
    own = max(rows / ranks, 1.0)
    reach = (row / {2: pi, 3: 4.0 / 3.0 * pi}[dim]) ** (1.0 / dim)
    near = (1.0 + 2.0 * reach / own ** (1.0 / dim)) ** dim - 1.0
    near = max(near, line["matrix_to_max"]) if rows > ranks else min(near, row)
    return min(near, rows, ranks - 1.0)


def _rounds(measured, name):
    """Rounds of exchanges of a level, but for the coarsest."""
    return measured.counts(name)[0] / (measured.messages["levels"] - 1)


def _on_levels(measured, network, line, name):
    """Time of the exchanges of a cycle or a set-up on all levels; bytes go with those of a product."""
    levels = measured.levels(line["particles"])
    rounds = _rounds(measured, name)
    time = sum(rounds * _neighbours(line, *level) * network.latency for level in levels[:-1])
    size = measured.counts(name)[1] / measured.counts("product")[1] * DOUBLE * line["matrix_received_max"]
    return time + size / network.bandwidth


def _cycle(measured, network, line):
    return _on_levels(measured, network, line, "cycle")


def _set_up(measured, network, line):
    levels = measured.levels(line["particles"])
    sums = measured.counts("set-up")[2] / (measured.messages["levels"] - 1) * (len(levels) - 1)
    return _on_levels(measured, network, line, "set-up") + sums * network.together(int(line["ranks"]))


def _sums_of_iteration(measured):
    return (measured.counts("10 iterations")[2] - measured.counts("5 iterations")[2]) / 5.0


def _other_sums(measured):
    """Collectives of a step outside Krylov iterations."""
    total = sum(counts[2] for name, counts in measured.messages["counts"].items() if name.startswith("step/"))
    return max(total - measured.messages["iterations"] * _sums_of_iteration(measured), 0.0)


def _other_rounds(measured):
    """Exchanges of both solves that are no iterations and no updates of ghosts: matrices, residuals."""
    counts = [values[0] for name, values in measured.messages["counts"].items()
              if name.startswith("step/") and name != "step/updates"]
    kept = measured.counts("kept cycle")[0] + measured.counts("product")[0]
    return max(sum(counts) - measured.counts("step/updates")[0] - measured.messages["iterations"] * kept, 0.0)


def table(measured: Measured, network: Network, lines: list[dict[str, float]]) -> list[dict[str, float]]:
    """Return a line for each of one scene: ranks, particles of a rank, ms of each part and in all, efficiency."""
    found = []
    alone = None
    for line in sorted(lines, key=lambda one: one["ranks"]):
        parts = step(measured, network, line)
        total = sum(parts.values())
        one = {**line, "ranks": 1, "owned_max": line["particles"], "halo_received_max": 0.0}
        alone = alone or sum(step(measured, network, one).values())
        found.append({"ranks": int(line["ranks"]), "particles/rank": line["particles"] / line["ranks"],
                      **{name: 1e3 * seconds for name, seconds in parts.items()}, "ms": 1e3 * total,
                      "efficiency": alone / (total * line["ranks"])})
    return found


def scenes(path: Path) -> dict[tuple[int, int], list[dict[str, float]]]:
    """Return the lines of partitions.csv by dimension and power of ten of the particles."""
    found: dict[tuple[int, int], list[dict[str, float]]] = {}
    with open(path, encoding="utf-8") as file:
        for line in csv.DictReader(file):
            numbers = {name: float(value) for name, value in line.items()}
            found.setdefault((int(numbers["dim"]), 10 ** round(log10(numbers["particles"]))), []).append(numbers)
    return found


def draw(tables: dict[tuple[int, int], list[dict[str, float]]], path: Path) -> None:
    """Draw efficiency against ranks, with the published value."""
    import matplotlib
    matplotlib.use("agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.0, 4.0), layout="constrained")
    for (dim, particles), lines in sorted(tables.items()):
        ranks, efficiency = ([line[name] for line in lines] for name in ("ranks", "efficiency"))
        axes.plot(ranks, efficiency, "o-" if dim == 2 else "s--", markersize=3, label=f"{dim}D, {particles:.0e}")
    axes.plot(*PUBLISHED, "k*", markersize=10, label="Guo et al. 2018, another scene")
    axes.set(xscale="log", xlabel="ranks", ylabel="strong efficiency", ylim=(0.0, 1.05))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, title="particles")
    figure.savefig(path, dpi=150)


def main() -> None:
    """Print the tables, and write them with the picture."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--latency", type=float, default=1.5, help="of a message [us]")
    parser.add_argument("--bandwidth", type=float, default=2.0, help="of a rank, when all send [GB/s]")
    parser.add_argument("--measured", type=Path, default=MEASURED, help="folder of the measured files")
    parser.add_argument("-o", "--output", type=Path, default=Path("studies/cost_model"))
    args = parser.parse_args()
    measured = Measured.read(args.measured)
    network = Network(1e-6 * args.latency, 1e9 * args.bandwidth)
    tables = {scene: table(measured[scene[0]], network, lines)
              for scene, lines in sorted(scenes(args.measured / "partitions.csv").items())}
    parts = [f"Latency {args.latency:g} us, {args.bandwidth:g} GB/s. Parts of a step in ms."]
    for (dim, particles), lines in tables.items():
        parts += [f"{dim}D, {particles:.0e} particles:",
                  markdown.table(list(lines[0]), [[f"{value:.3g}" if isinstance(value, float) else str(value)
                                                   for value in line.values()] for line in lines])]
    text = "\n\n".join(parts) + "\n"
    print(text, end="")
    args.output.mkdir(parents=True, exist_ok=True)
    (args.output / "model.md").write_text(text, encoding="utf-8")
    draw(tables, args.output / "efficiency.png")


if __name__ == "__main__":
    main()
