"""Shoaling of the solitary wave of cases/runup_synolakis.py by the Serre-Green-Naghdi equations, without particles.

    python run_scripts/studies/solitary_shoaling.py -o cases/computed/solitary_shoaling.csv
    python run_scripts/studies/solitary_shoaling.py --data ../shared/reference/measured    # also beside the experiment

About fifteen seconds of CPU time. A wave of H/d = 0.3 starts with its crest L = arccosh(sqrt 20)/sqrt(3H/4d) before the
toe of a beach of 1:19.85, as Synolakis (1987) states it, and is followed until t sqrt(g/d) = 15, when it is about to
break. The start is that of the case, the exact solitary wave with its mean velocity; the equations and the code are
others. So where both flows agree, what sets them apart from the experiment is neither particles nor steps.

Equations: Lannes & Bonneton (2009), Phys. Fluids 21, 016601, fully nonlinear, without loss, over a bed b,

    h_t + (h u)_x = 0,    (h + h T)(u_t + u u_x) + g h eta_x + h Q(u) = 0,
    h T w = -(h^3 w_x)_x / 3 + (h^2 b_x)_x w / 2 + h b_x^2 w,
    h Q = 2/3 (h^3 u_x^2)_x + h^2 u_x^2 b_x + (h^2 u^2 b_xx)_x / 2 + h u^2 b_xx b_x.

Scheme: central differences of second order, Runge-Kutta of fourth order in time, no filter and no limiter. The beach
ends in a shelf with a tenth of the depth, 2 d from the shore, because a shore that moves is left out. x is the distance
from the still shoreline; lengths are in d, times in sqrt(d/g), g = 1, and the wave travels towards -x.
"""

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from math import acosh, ceil, sqrt
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from parisph.case.profiles import Profiles, read_profiles  # noqa: E402
from parisph.case.waves import SolitaryWave  # noqa: E402
from parisph.io.files import write_text  # noqa: E402
from parisph.kernels.jit import uncached  # noqa: E402

HEIGHT = 0.3
SLOPE = 1.0 / 19.85
TOE = 1.0 / SLOPE
CREST = TOE + acosh(sqrt(20.0)) / sqrt(0.75 * HEIGHT)    # at the start
SHELF = 0.1                     # depth where the beach ends
BEND = 0.25                     # the slope of the bed changes within about this of the toe, instead of by a jump
DOMAIN = (-5.0, 50.0)           # the wave reaches neither end
STEP = 0.4                      # time step over the spacing; Runge-Kutta is stable to 2.8 over the speed, 1.2 at most
TIMES = (8.0, 10.0, 12.0, 14.0, 15.0)
PLACES = np.arange(3.0, 25.01, 0.25)
SPACING = 1 / 80
MEASURED = "05b_synolakis1987_profiles.csv"
SHIFTS = np.arange(-2.0, 2.001, 0.05)
# what "a solitary wave of this height" may mean, and one that is lower by a sixth
STARTS = {"exact": ("exact", HEIGHT), "of the equations": ("own", HEIGHT), "Boussinesq's": ("boussinesq", HEIGHT),
          "exact, H/d = 0.25": ("exact", 0.25)}


@dataclass(frozen=True)
class Bed:
    """A bed on an even grid.

    x : (n,); height : (n,) above the deepest bed; slope, bend : (n,) its first and second derivative
    """

    x: np.ndarray
    height: np.ndarray
    slope: np.ndarray
    bend: np.ndarray

    @property
    def spacing(self) -> float:
        """Distance of the points."""
        return float(self.x[1] - self.x[0])


def flat(spacing: float, lower: float, upper: float) -> Bed:
    """Return a level bed from `lower` to `upper`."""
    x = lower + spacing * np.arange(round((upper - lower) / spacing) + 1)
    return Bed(x, *np.zeros((3, len(x))))


def beach(spacing: float) -> Bed:
    """Return the beach between the toe and the shelf, both rounded as hyperbolas."""
    x = flat(spacing, *DOMAIN).x
    height, slope, bend = np.zeros((3, len(x)))
    for end, sign in ((TOE, 1.0), (SHELF / SLOPE, -1.0)):
        y = end - x
        root = np.sqrt(y * y + BEND * BEND)
        height += sign * SLOPE * 0.5 * (y + root)
        slope -= sign * SLOPE * 0.5 * (1.0 + y / root)
        bend += sign * SLOPE * 0.5 * BEND * BEND / root**3
    return Bed(x, height, slope, bend)


def solitary(x: np.ndarray, height: float, crest: float, theory: str = "own") -> tuple[np.ndarray, np.ndarray]:
    """Return elevation and mean velocity of a solitary wave in depth 1.

    theory : "own", that of these equations, which then keeps its form; else one that parisph's SolitaryWave knows
    """
    if theory == "own":
        speed = sqrt(1.0 + height)
        eta = height / np.cosh(sqrt(0.75 * height) / speed * (x - crest)) ** 2
    else:
        wave = SolitaryWave(height=height, depth=1.0, at=crest, theory=theory, g=1.0, leftward=True)
        speed, eta = wave.celerity, wave.elevation(x, 0.0)
    return eta, -speed * eta / (1.0 + eta)    # what a flow that is steady in the frame of the wave carries


def flow(bed: Bed, eta: np.ndarray, u: np.ndarray, times: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return elevation and mean velocity (len(times), n) at rising times, from those at the start (n,)."""
    state, now, found = np.array([1.0 + eta - bed.height, u]), 0.0, []
    for end in times:
        steps = ceil((end - now) / (STEP * bed.spacing))
        for _ in range(steps):
            state = _stepped(bed, state, (end - now) / steps)
        now = end
        found.append((state[0] + bed.height - 1.0, state[1]))
    return np.array([eta for eta, _ in found]), np.array([u for _, u in found])


def _stepped(bed: Bed, state: np.ndarray, dt: float) -> np.ndarray:
    """Return depth and velocity (2, n) after a step of Runge-Kutta."""
    first = _rates(bed, state)
    second = _rates(bed, state + 0.5 * dt * first)
    third = _rates(bed, state + 0.5 * dt * second)
    return state + dt / 6.0 * (first + 2.0 * (second + third) + _rates(bed, state + dt * third))


def _rates(bed: Bed, state: np.ndarray) -> np.ndarray:
    """Return h_t and u_t (2, n)."""
    (h, u), dx = state, bed.spacing
    hh, ux = h * h, _derivative(u, dx)
    lift, stretch = hh * u * u * bed.bend, hh * ux * ux
    force = h * _derivative(h + bed.height, dx) + (stretch + lift / h) * bed.slope
    force += _derivative(2.0 / 3.0 * h * stretch + 0.5 * lift, dx)
    middle = h + 0.5 * _derivative(hh * bed.slope, dx) + h * bed.slope * bed.slope
    return np.array([-_derivative(h * u, dx), _solved(h, middle, -force, dx) - u * ux])


def _derivative(f: np.ndarray, dx: float) -> np.ndarray:
    """Return the central difference, 0 at the ends, where the water rests."""
    found = np.zeros_like(f)
    found[1:-1] = (f[2:] - f[:-2]) / (2.0 * dx)
    return found


@uncached
def _solved(h, middle, right, dx):
    """Return w with middle w - (h^3 w_x)_x / 3 = right, and w = 0 at the ends (elimination of Thomas)."""
    n = len(h)
    w, above = np.zeros(n), np.zeros(n)
    after = -(0.5 * (h[0] + h[1])) ** 3 / (3.0 * dx * dx)
    for i in range(1, n - 1):
        before, after = after, -(0.5 * (h[i] + h[i + 1])) ** 3 / (3.0 * dx * dx)
        pivot = middle[i] - before - after - before * above[i - 1]
        above[i] = after / pivot
        w[i] = (right[i] - before * w[i - 1]) / pivot
    for i in range(n - 2, 0, -1):
        w[i] -= above[i] * w[i + 1]
    return w


def form_error(spacing: float, after: float = 20.0) -> float:
    """Return by how much the wave of the equations has changed or is off its place after some time on a level bed.

    It is relative L2, and should be 0.
    """
    way = sqrt(1.0 + HEIGHT) * after
    bed = flat(spacing, -15.0, way + 15.0)
    found = flow(bed, *solitary(bed.x, HEIGHT, way), [after])[0][0]
    due = solitary(bed.x, HEIGHT, 0.0)[0]
    return float(np.linalg.norm(found - due) / np.linalg.norm(due))


def shoaled(spacing: float, theory: str = "exact", height: float = HEIGHT,
            times: Sequence[float] = TIMES) -> tuple[Bed, np.ndarray]:
    """Return the beach, and the elevation (len(times), n) at the times."""
    bed = beach(spacing)
    return bed, flow(bed, *solitary(bed.x, height, CREST, theory), times)[0]


def at_places(bed: Bed, eta: np.ndarray) -> np.ndarray:
    """Return elevations (len(times), len(PLACES)) at the places of the table."""
    return np.array([np.interp(PLACES, bed.x, one) for one in eta])


def table(spacing: float) -> str:
    """Return the file of profiles, whose head says how it was made and how far it has converged."""
    start = time.process_time()
    eta = at_places(*shoaled(spacing))
    cost = time.process_time() - start
    change = np.abs(at_places(*shoaled(0.5 * spacing)) - eta).max(axis=1)
    head = f"""\
# Solitary wave, H/d = {HEIGHT:g}, on a beach of 1:{1.0 / SLOPE:g} before it breaks; computed for this project.
# Made by run_scripts/studies/solitary_shoaling.py: equations of Serre, Green & Naghdi (Lannes & Bonneton 2009, Phys.
# Fluids 21, 016601), central differences of second order, Runge-Kutta of fourth, no loss, no filter. The start is the
# exact solitary wave with its mean velocity, crest at x = {CREST:.4f}, arccosh(sqrt 20)/sqrt(3H/4d) before the toe.
# Spacing d/{1.0 / spacing:g}, {cost:.0f} s of CPU time. With half of it, values change by at most
# {", ".join(f"{value:.1g}" for value in change)} d at the five times.
# x: distance from the still shoreline over d, offshore; eta: elevation over d.
t_sqrt_g_over_d,x_over_d,eta_over_d
"""
    return head + "".join(f"{t:g},{x:g},{value:.5f}\n" for t, line in zip(TIMES, eta) for x, value in zip(PLACES, line))


def beside(file: str, spacing: float) -> str:
    """Return how far the waves of all starts are from the measured profile at the last time, as they are and moved."""
    rows = {"H_over_d": f"{HEIGHT:g}", "t_sqrt_g_over_d": f"{TIMES[-1]:g}"}
    (_, x, due), = read_profiles(Profiles(file, time="t_sqrt_g_over_d", x="x_over_d", value="eta_over_d", rows=rows))
    lines = [f"t sqrt(g/d) = {TIMES[-1]:g}, {len(x)} measured points; rms is over H = {HEIGHT:g} d",
             "start               crest x/d  eta/d    rms  moved offshore by [d]    rms"]
    for name, (theory, height) in STARTS.items():
        bed, (eta,) = shoaled(spacing, theory, height, TIMES[-1:])
        k, apart = int(np.argmax(eta)), distances(bed.x, eta, x, due)
        best = int(np.argmin(apart))
        lines.append(f"{name:<18} {bed.x[k]:10.2f} {eta[k]:6.3f} {distances(bed.x, eta, x, due, [0.0])[0]:6.3f} "
                     f"{SHIFTS[best]:22.2f} {apart[best]:6.3f}")
    return "\n".join(lines)


def distances(x: np.ndarray, eta: np.ndarray, at: np.ndarray, due: np.ndarray,
              shifts: Sequence[float] | np.ndarray = SHIFTS) -> list[float]:
    """Return the rms distance over H of a profile from points if it is moved offshore by each of the shifts."""
    return [float(np.sqrt(np.mean((np.interp(at - shift, x, eta) - due) ** 2))) / HEIGHT for shift in shifts]


def main() -> None:
    """Check the solver, write the table, and compare with the experiment."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("-o", "--output", type=Path, help="CSV file of the profiles")
    parser.add_argument("--data", type=Path, help=f"folder with {MEASURED}")
    parser.add_argument("--spacing", type=float, default=SPACING, help=f"of the grid, in d (default {SPACING:g})")
    args = parser.parse_args()
    spacings = [4.0 * args.spacing, 2.0 * args.spacing]
    print("A solitary wave on a level bed, 20 sqrt(d/g), is off by "
          + " and ".join(f"{form_error(s):.2g}" for s in spacings)
          + " (relative L2) with spacings of " + " and ".join(f"{s:g} d" for s in spacings))
    if args.output:
        text = table(args.spacing)
        write_text(args.output, text)
        print("".join(line for line in text.splitlines(keepends=True) if line.startswith("#")), end="")
    if args.data:
        print(beside(str(args.data / MEASURED), args.spacing))


if __name__ == "__main__":
    main()
