"""Pictures of the flow from the folder of a run. Needs matplotlib, the extra [plot]; needs no MPI."""

from pathlib import Path

import numpy as np

from parisph.base.errors import CaseError, StoreError
from parisph.base.fields import BALLISTIC, FLUID, INNER, SURFACE, WALL, WET
from parisph.io import style
from parisph.io.reader import Run, open_run

# Diameters in spacings: a drawn particle; and the ground below those inside, which closes the gaps that
# discs leave between them, without making the surface thicker than half a particle.
DISC, GROUND = 1.05, 1.8


def plot_field(run, which=-1, field="pressure", path=None, surface=False, normalise=False, limits=None):
    """Draw the particles of one snapshot, coloured by a quantity; return the matplotlib Figure.

    Parameters
    ----------
    run : Run, or the folder of one
    which : number of the snapshot (int, also from the end), or the one nearest a time [s] (float)
    field : "pressure", "speed", "velocity_x", "velocity_y", "density_ratio" or "role"
    path : file to write (.png, .pdf, ...), or None
    surface : whether particles on the free surface are ringed, and ballistic ones too
    normalise : lengths by H, pressures by rho g H, velocities by sqrt(g H)
    limits : (lowest, highest) of the colours in the picture's unit, or None to fit them to the bulk of the values

    Raises
    ------
    CaseError : no such quantity, or nothing to normalise by
    StoreError : no such snapshot, or the quantity was not written
    """
    run = run if isinstance(run, Run) else open_run(run)
    snapshot = run.snapshot(which)
    view = FieldView(run.case, [snapshot], field, surface, normalise)
    picture = style.drawing().Figure(figsize=view.size(), layout="compressed")
    axes = picture.add_subplot()
    view.add_colour_bar(picture, axes, view.draw(axes, snapshot, limits), [snapshot])
    style.save(picture, path)
    return picture


def movie(run, path, field="pressure", surface=False, normalise=False, limits=None, frames_per_second=20, dpi=100):
    """Write all snapshots as an animation: .gif, or .mp4 where ffmpeg is installed; return its path.

    Colours and axes are the same in every frame: `limits`, or what suits the bulk of all frames.
    Other parameters as of plot_field. Raises CaseError (also for another ending), StoreError.
    """
    run = run if isinstance(run, Run) else open_run(run)
    figure, path = style.drawing(), Path(path)
    writer = _movie_writer(path, frames_per_second)
    if len(run) == 0:
        raise StoreError(f"{run.folder} has no snapshots")
    some = [run.snapshot(int(number)) for number in np.unique(np.linspace(0, len(run) - 1, 24).round())]
    view = FieldView(run.case, some, field, surface, normalise)
    limits = limits or view.common_limits(some)
    picture = figure.Figure(figsize=view.size(), dpi=dpi, layout="constrained")
    axes = picture.add_subplot()
    try:
        with writer.saving(picture, str(path), dpi):
            for number in range(len(run)):
                axes.clear()
                discs = view.draw(axes, run.snapshot(number), limits)
                view.add_colour_bar(picture, axes, discs, some)
                if number == 0:  # one layout for all frames, so that nothing jumps
                    picture.draw_without_rendering()
                    picture.set_layout_engine("none")
                writer.grab_frame()
    except OSError as error:
        raise StoreError(f"cannot write the movie {path}: {error}") from None
    return path


class FieldView:
    """How snapshots of one run are drawn: scales, walls, colours, and a window that suits those given."""

    def __init__(self, case, snapshots, field, surface=False, normalise=False):
        if snapshots[0]["x"].shape[1] != 2:
            raise StoreError("pictures are drawn of flows in the plane only: open the run's .series file in ParaView")
        self.case, self.name, self.surface, self.normalise = case, field, surface, normalise
        self.quantity, self.own = style.quantity(field), style.scales(case)
        if normalise and self.own.time is None:
            raise CaseError("this scene has no constant gravity: it has no sqrt(g H) to divide by")
        self.length = self.own.length if normalise else 1.0
        self.spacing = case["numerics"]["spacing"] / self.length
        self.window = self._window(snapshots)

    def size(self, width=8.0):
        """Figure size [inch] that suits the window: the axes fill it, with room for labels and colour bar."""
        (left, right), (low, high) = self.window
        height = 0.84 * width * (high - low) / (right - left) + 1.2
        return (width, height) if height <= 9.0 else (max(4.0, width * 9.0 / height), 9.0)

    def draw(self, axes, snapshot, limits=None, label=True):
        """Draw one snapshot into axes; return the coloured collection, or None for roles."""
        x, values = snapshot["x"] / self.length, self.values(snapshot)
        fluid = snapshot["kind"] == FLUID
        ground = (fluid & (snapshot["role"] == INNER)) | self._walls_to_fill(snapshot)
        layers = [(self._discs(axes, x[rows], size), values[rows]) for rows, size in ((ground, GROUND), (fluid, DISC))]
        # The ground is cut at the walls. Particles are not: one that crosses a wall is seen.
        self._draw_walls(axes, cut=layers[0][0])
        low, high = limits or self.limits(values[fluid])
        for discs, colour in layers:
            if self.name == "role":
                discs.set_facecolor([style.ROLES[int(role)][1] for role in colour])
            else:
                discs.set(array=colour, cmap=self.quantity.colours, clim=(low, high))
        if self.name == "role":
            self._name_roles(axes, snapshot["role"][fluid | ground])
        elif self.surface:
            self._ring(axes, x, snapshot)
        self._finish(axes, snapshot["time"], label)
        return None if self.name == "role" else layers[1][0]

    def values(self, snapshot):
        """The quantity in the picture's unit, (n,)."""
        needed = self.quantity.needs
        if needed not in snapshot:
            raise StoreError(f"{self.name} cannot be shown: the field {needed!r} was not written (see Output.fields)")
        values = np.asarray(self.quantity.of(snapshot[needed]), dtype=float)
        return values * self._factor()

    def limits(self, values):
        """Limits of the colours that suit the bulk of the values: single spikes do not dim the picture."""
        values = np.sort(values[np.isfinite(values)])
        if len(values) < 3:
            return 0.0, 1.0
        spikes = min(-(-len(values) // 200), (len(values) - 1) // 2)  # at either end, one at least
        low, high = values[spikes], values[-1 - spikes]
        centre = self.quantity.centre
        if centre is not None:
            reach = max(abs(low - centre), abs(high - centre)) or 1.0
            return centre - reach, centre + reach
        if low > -0.05 * high:  # positive but for noise: start at zero, where the colours mean something
            low = 0.0
        return (low, high) if high > low else (low, low + 1.0)

    def common_limits(self, snapshots):
        """Limits of the colours for all snapshots together; a few moments of impact do not dim the rest."""
        if self.name == "role":
            return None
        return self.limits(self._fluid_values(snapshots))

    def add_colour_bar(self, picture, axes, discs, snapshots):
        """Add the colour bar of `discs`, pointed where values of the snapshots lie beyond it; nothing for roles.

        axes : one, which the bar then is as high as, or a list of them
        """
        if discs is None:
            return
        values = self._fluid_values(snapshots)
        beyond = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
        low, high = discs.get_clim()
        extend = beyond[bool(np.any(values < low)), bool(np.any(values > high))]
        beside = {"ax": axes, "aspect": 25, "pad": 0.02} if isinstance(axes, list) else {"cax": axes.inset_axes((1.02, 0.0, 0.025, 1.0))}
        bar = picture.colorbar(discs, extend=extend, **beside)
        bar.set_label(self._label())
        bar.outline.set_linewidth(0.5)

    def _fluid_values(self, snapshots):
        return np.concatenate([self.values(snapshot)[snapshot["kind"] == FLUID] for snapshot in snapshots])

    def _factor(self):
        scale = getattr(self.own, self.quantity.scale) if self.quantity.scale else None
        if self.normalise and scale:
            return 1.0 / scale
        return style.with_prefix(scale or 0.0, self.quantity.unit)[0]

    def _label(self):
        if self.normalise and self.quantity.scale:
            by = {"pressure": r"(\rho g H)", "speed": r"\sqrt{gH}"}[self.quantity.scale]
            return rf"{self.quantity.symbol}$\,/\,{by}$"
        scale = getattr(self.own, self.quantity.scale) if self.quantity.scale else 0.0
        unit = style.with_prefix(scale or 0.0, self.quantity.unit)[1]
        return f"{self.quantity.symbol} [{unit}]" if unit else self.quantity.symbol

    def _window(self, snapshots):
        """((left, right), (low, high)) of the axes: the fluid of the snapshots, and the tank but for its empty top."""
        x = np.concatenate([snapshot["x"][snapshot["kind"] == FLUID] for snapshot in snapshots])
        low, high = x.min(axis=0), x.max(axis=0)
        tank = self.case.get("walls")
        if tank:
            left = np.array(tank["at"], dtype=float)
            right = left + np.array([tank["width"], tank["height"]])
            full = high[1] > left[1] + 0.7 * tank["height"]
            top = right[1] if full else min(right[1], left[1] + 1.2 * (high[1] - left[1]))
            low, high = np.minimum(low, left), np.maximum(high, (right[0], top))
        margin = 0.03 * np.max(high - low)
        low, high = (low - margin) / self.length, (high + margin) / self.length
        return (low[0], high[0]), (low[1], high[1])

    def _walls_to_fill(self, snapshot):
        """Wet wall particles carry the pressure on the wall; they close the gap of half a spacing to it."""
        wet = (snapshot["kind"] == WALL) & (snapshot["role"] == WET)
        return wet if self.quantity.needs in ("p", "role") else np.zeros_like(wet)

    def _discs(self, axes, x, diameter, **how):
        """Discs of the particles' size in the units of the axes, so that they stay right when one zooms in."""
        from matplotlib.collections import EllipseCollection

        size = np.full(len(x), diameter * self.spacing)
        how = {"linewidths": 0.0, **how}
        discs = EllipseCollection(size, size, np.zeros(len(x)), units="xy", offsets=x, offset_transform=axes.transData, **how)
        discs.set_in_layout(False)
        axes.add_collection(discs)
        return discs

    def _name_roles(self, axes, roles):
        from matplotlib.patches import Patch

        present = [style.ROLES[role] for role in style.ROLES if np.any(roles == role)]
        axes.legend(handles=[Patch(facecolor=colour, label=name) for name, colour in present],
                    loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize=9)

    def _draw_walls(self, axes, cut):
        """Draw the tank as lines, and cut the discs `cut` to what is inside."""
        from matplotlib.patches import Rectangle

        tank = self.case.get("walls")
        if not tank:
            return
        (left, low), width, height = np.array(tank["at"]) / self.length, tank["width"] / self.length, tank["height"] / self.length
        right, top = left + width, low + height
        corners = [(left, top), (left, low), (right, low), (right, top)] + ([(left, top)] if tank["lid"] else [])
        axes.plot(*np.transpose(corners), color=style.WALL_COLOUR, linewidth=2.0, solid_joinstyle="miter", zorder=3)
        cut.set_clip_path(Rectangle((left, low), width, height, transform=axes.transData))

    def _ring(self, axes, x, snapshot):
        from matplotlib.lines import Line2D

        handles = []
        for role in (SURFACE, BALLISTIC):
            name, colour = style.ROLES[role]
            chosen = (snapshot["kind"] == FLUID) & (snapshot["role"] == role)
            if np.any(chosen):
                self._discs(axes, x[chosen], DISC, facecolors="none", edgecolors=colour, linewidths=0.8, zorder=4)
                handles.append(Line2D([], [], marker="o", linestyle="", markerfacecolor="none", color=colour, label=name))
        if handles:
            axes.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False, fontsize=9,
                        borderaxespad=0.2, handletextpad=0.1)

    def _finish(self, axes, time, label):
        axes.set_xlim(self.window[0])
        axes.set_ylim(self.window[1])
        axes.set_aspect("equal")
        axes.set_xlabel("$x/H$" if self.normalise else "$x$ [m]")
        axes.set_ylabel("$y/H$" if self.normalise else "$y$ [m]")
        axes.tick_params(direction="in", top=True, right=True)
        if label:
            axes.set_title(self.case["title"] + "\n" + style.time_label(time, self.own), loc="left", fontsize=11)
        else:
            axes.set_title(style.time_label(time, self.own), loc="left", fontsize=9)


def _movie_writer(path, frames_per_second):
    from matplotlib import animation

    if path.suffix == ".gif":
        return animation.PillowWriter(fps=frames_per_second)
    if path.suffix != ".mp4":
        raise CaseError(f"{path}: a movie ends in .gif or .mp4")
    if not animation.FFMpegWriter.isAvailable():
        raise StoreError("an .mp4 needs the program ffmpeg, which is not installed: write a .gif instead")
    return animation.FFMpegWriter(fps=frames_per_second, extra_args=["-pix_fmt", "yuv420p"])
