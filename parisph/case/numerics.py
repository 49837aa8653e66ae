"""Numerics and output of a case: method, resolution, time step, files."""

from collections.abc import Iterable
from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator, model_validator

from parisph.base import vocabulary
from parisph.base.fields import FIELDS
from parisph.base.text import shown
from parisph.case.methods import METHODS
from parisph.case.model import Model, Several
from parisph.case.presets import PRESETS

Fraction = Annotated[float | None, Field(ge=0, le=1)]
Distance = Annotated[float | None, Field(ge=0, le=2, description="a distance in particle spacings, 0 to 2")]

# {field: kind of part (base.vocabulary)} of fields with the name of one part, and with several.
WORDS = {name: name for name in ("laplacian", "divergence", "gradient", "surface_gradient", "wall_rows", "surface_rule",
                                 "source", "stepping")}
LISTS = {"forces": "force", "regularisers": "regulariser"}


class Numerics(Model):
    """Method, resolution and time step. Fields that are None take the preset's value.

    spacing : particle spacing s [m]
    method, preset : names, see METHODS and PRESETS
    time_step : fixed time step [s]; None for an adaptive one, see methods.timestep: it is limited by `cfl` (largest
        move in a step, in s), by `fall` and by `wave_step`, and is at most a fiftieth of the period of a Sway
    fall : largest adaptive step over sqrt(l/a). l is s, or a twentieth of the thickness of the fluid if that is more; a
        is 1.5 times the largest acceleration of the fluid, at most the body force, or 1.25 times its root mean square
        if that is more. If it is not 0, a step strains the fluid by at most 1.5 % in the mean. These two limits are at
        least the time in which the fastest fluid moves a tenth of a spacing
    wave_step : largest adaptive step of waves over sqrt(s/g), the time scale of the shortest ones on the lattice. If it
        is not 0, a step strains the fluid by at most .7 % in the mean, by the largest strain of the last waves
    max_time_step : upper limit of an adaptive step [s]
    zeta_time : relaxation time of the divergence [s], zeta = dt/zeta_time; 0 to use zeta
    zeta, gamma : weights of divergence and of density in the pressure source (Z14 Eq 19)
    residual_strain : part of the residual divergence of earlier steps that a step removes, over dt sqrt(2 G:G) with
        G = grad u, or over dt sqrt(g/s) if that is more; at most all of it; 0 for all in every step
    volume_time : time over sqrt(s/g) in which steps give back the volume that residual divergence has made; 0 for never
    strain : weight of the strain source, which conserves volume in a finite step; 0 or 1
    kappa, shift : greatest weights of the position projection and of the Fick shift
    smagorinsky : C_s of Smagorinsky's eddy viscosity (C_s s)^2 sqrt(2 S:S), 0 for none
    filter : greatest fraction of the velocity's roughness that a step removes; also the rate over sqrt(a/s) at which
        the part of the velocity beyond a potential flow is removed, with the acceleration a by pressure
    kappa_strain, shift_strain, filter_strain : these weights over the strain of a step, dt sqrt(2 S:S), up to the
        greatest; 0 for the greatest in every step
    collision_distance, wall_guard : [s]; restitution : of pair collisions; 0 switches them off
    laplacian, divergence, gradient, surface_gradient, wall_rows, surface_rule, source, stepping, forces, regularisers :
        names of the parts of a step, in place of those of the method and the preset (see base.vocabulary)
    surface_offset : distance of p = 0 beyond a surface particle with a full cell, over the distance of the last two
        layers (one spacing where the flow has not stretched them); 0 for p = 0 at particles
    pressure_mean : half the time over which pressure probes take means, over the shortest time that particles resolve
        (methods.timestep), if steps are shorter; 0 for means over adjacent steps only
    rtol : relative tolerance of the pressure solve
    equation_of_state, sound_speed, artificial_viscosity, xsph : of the method SPH alone (Z14 Eqs 3, 8, 9); the speed of
        sound [m/s] is by default ten times the expected largest speed
    jitter : k of a start displacement s k (Rn - 1/2) of fluid particles in each direction, Rn uniform in [0, 1) (Z17
        Sec. 4); of particles on the free surface only if jitter_surface
    seed : seed of the jitter

    >>> Numerics(spacing=0.02).resolved().cfl    # from the preset "violent"
    0.8
    >>> waves = Numerics(spacing=0.02, preset="gentle", time_step=0.002, jitter=0.2, seed=1)
    >>> papers = Numerics(spacing=0.02, method="Z14_CISPH2")
    >>> other = Numerics(spacing=0.02, laplacian="gfd", surface_rule="density")
    """

    spacing: float = Field(gt=0, description="particle spacing [m]")
    method: str = Field(default="ISPH_R", description="name of the method")
    preset: str = Field(default="violent", description="name of the preset")
    time_step: float | None = Field(default=None, gt=0, description="fixed time step [s], or None to adapt it")
    cfl: float | None = Field(default=None, gt=0, le=2,
                              description="largest move of a particle in one adaptive step, in spacings")
    fall: float | None = Field(
        default=None, ge=0, le=2,
        description="largest adaptive step of moving fluid over sqrt(length/acceleration), 0 for no limit; the length "
                    "is the spacing, or 1/20 of the thickness of the fluid")
    wave_step: float | None = Field(
        default=None, ge=0, le=2, description="largest adaptive step of waves over sqrt(spacing/g), 0 for no limit")
    max_time_step: float | None = Field(default=None, gt=0, description="upper limit of an adaptive step [s]")
    zeta_time: float | None = Field(default=None, ge=0, description="relaxation time of the divergence [s], 0 for none")
    zeta: float | None = Field(default=None, gt=0, le=2, description="weight of the divergence in the source")
    residual_strain: float | None = Field(
        default=None, ge=0, le=1000, description="part of the residual divergence removed over the strain of a step")
    volume_time: float | None = Field(
        default=None, ge=0, le=10000, description="time over which volume made by residual divergence is given back, "
                                          "over sqrt(spacing/g), 0 for never")
    gamma: Fraction = None
    strain: Fraction = None
    kappa: float | None = Field(default=None, ge=0, le=2, description="weight of the position projection")
    shift: float | None = Field(default=None, ge=0, le=2, description="weight C of the Fick shift")
    kappa_strain: float | None = Field(default=None, ge=0, le=1000,
                                       description="weight of the position projection over the strain of a step")
    shift_strain: float | None = Field(default=None, ge=0, le=1000,
                                       description="weight C of the Fick shift over the strain of a step")
    filter: Fraction = None
    filter_strain: float | None = Field(default=None, ge=0, le=1000,
                                        description="fraction of roughness removed over the strain of a step")
    collision_distance: Distance = None
    restitution: Fraction = None
    wall_guard: Distance = None
    laplacian: str | None = Field(default=None, description="name of the Laplacian")
    divergence: str | None = Field(default=None, description="name of the divergence")
    source: str | None = Field(default=None, description="name of the pressure equation's source")
    smagorinsky: float = Field(default=0.0, ge=0, le=1,
                               description="constant C_s of the eddy viscosity (C_s s)^2 |S|, 0 for none")
    forces: Several[str] | None = Field(default=None, description="names of the forces")
    regularisers: Several[str] | None = Field(default=None, description="names of the regularisers, in their order")
    surface_rule: str | None = Field(default=None, description="name of the rule that finds the free surface")
    surface_offset: float | None = Field(default=None, ge=0, le=1,
                                         description="distance of p = 0 from full surface particles, in layers")
    pressure_mean: float | None = Field(
        default=None, ge=0, le=100,
        description="time of the means of pressure probes, over twice that which particles resolve")
    wall_rows: str | None = Field(default=None, description="name of the rows of wall particles")
    gradient: str | None = Field(default=None, description="name of the pressure gradient")
    surface_gradient: str | None = Field(default=None, description="name of the pressure gradient at the surface")
    stepping: str | None = Field(default=None, description="name of the stepping in time")
    rtol: float | None = Field(default=None, gt=0, lt=1, description="relative tolerance of the pressure solve")
    equation_of_state: Literal["tait", "linear"] = Field(
        default="tait", description="pressure of weakly compressible fluid")
    sound_speed: float | None = Field(
        default=None, gt=0, description="speed of sound of weakly compressible fluid [m/s]")
    artificial_viscosity: float = Field(default=0.3, ge=0, le=10,
                                        description="omega of the artificial viscosity of weakly compressible fluid")
    xsph: float = Field(default=0.01, ge=0, le=1,
                        description="epsilon of XSPH: how far weakly compressible fluid moves with its neighbours")
    jitter: float = Field(default=0.0, ge=0, le=1.2, description="disorder k of the start positions, 0 to 1.2")
    jitter_surface: bool = Field(default=False, description="whether particles on the free surface are jittered too")
    seed: int = Field(default=0, ge=0, lt=2**63, description="seed of the jitter")

    @field_validator("method")
    @classmethod
    def _known_method(cls, name: str, info: ValidationInfo) -> str:
        return name if info.context else _known("method", name, METHODS)

    @field_validator(*WORDS)
    @classmethod
    def _known_part(cls, word: str | None, info: ValidationInfo) -> str | None:
        if word is None or info.context:    # a run opened only for reading may have unknown parts
            return word
        field = str(info.field_name)
        return _known(field, word, vocabulary.known(WORDS[field]))

    @field_validator(*LISTS)
    @classmethod
    def _known_parts(cls, words: tuple[str, ...] | None, info: ValidationInfo) -> tuple[str, ...] | None:
        what = LISTS[str(info.field_name)]
        for word in () if info.context else words or ():
            _known(what, word, vocabulary.known(what))
        return words

    @field_validator("preset")
    @classmethod
    def _known_preset(cls, name: str) -> str:
        return _known("preset", name, PRESETS)

    @model_validator(mode="after")
    def _one_relaxation(self) -> "Numerics":
        if self.zeta is not None and self.zeta_time:
            raise ValueError(
                f"zeta = {self.zeta} and zeta_time = {self.zeta_time}: give only one of them, "
                "the other follows from the time step"
            )
        if self.max_time_step is not None and self.time_step is not None:
            raise ValueError(
                f"max_time_step = {self.max_time_step}: limits an adaptive step only; "
                f"leave out time_step = {self.time_step} to have one"
            )
        return self

    def resolved(self) -> "ResolvedNumerics":
        """Return a copy in which the values of the method, or else of the preset, replace None."""
        values = {**PRESETS[self.preset], **METHODS[self.method].values}
        missing = {name: value for name, value in values.items() if getattr(self, name) is None}
        if self.zeta is not None:
            missing["zeta_time"] = 0.0
        elif self.zeta_time:
            missing.pop("zeta", None)  # follows from the time step
        return ResolvedNumerics.model_construct(self.model_fields_set | missing.keys(), **{**vars(self), **missing})


class ResolvedNumerics(Numerics):
    """Numerics without None where None means "from the method or preset": see Numerics.resolved.

    `zeta` is None if it follows from zeta_time.
    """

    cfl: float = Field(kw_only=True)
    fall: float = Field(kw_only=True)
    wave_step: float = Field(kw_only=True)
    zeta_time: float = Field(kw_only=True)
    residual_strain: float = Field(kw_only=True)
    volume_time: float = Field(kw_only=True)
    gamma: float = Field(kw_only=True)
    strain: float = Field(kw_only=True)
    kappa: float = Field(kw_only=True)
    shift: float = Field(kw_only=True)
    kappa_strain: float = Field(kw_only=True)
    shift_strain: float = Field(kw_only=True)
    filter: float = Field(kw_only=True)
    filter_strain: float = Field(kw_only=True)
    collision_distance: float = Field(kw_only=True)
    restitution: float = Field(kw_only=True)
    wall_guard: float = Field(kw_only=True)
    laplacian: str = Field(kw_only=True)
    divergence: str = Field(kw_only=True)
    source: str = Field(kw_only=True)
    forces: Several[str] = Field(kw_only=True)
    regularisers: Several[str] = Field(kw_only=True)
    surface_rule: str = Field(kw_only=True)
    surface_offset: float = Field(kw_only=True)
    pressure_mean: float = Field(kw_only=True)
    wall_rows: str = Field(kw_only=True)
    gradient: str = Field(kw_only=True)
    surface_gradient: str = Field(kw_only=True)
    stepping: str = Field(kw_only=True)
    rtol: float = Field(kw_only=True)


class Output(Model):
    """What is written and when. Snapshots of the start and the end of a run are always written.

    every : time between snapshots [s]; each is of the end of the nearest step, so output changes no step
    times : further times of snapshots [s], likewise
    fields : names of the particle fields in snapshots
    checkpoint_every : simulated time between checkpoints [s], None for only one at the end
    probe_every : steps between samples of the probes
    probe_interval : time between samples of the probes [s], instead of `probe_every`; with linear interpolation
    budget : whether steps.csv also has the energy that the fluid gained by each part of the step

    >>> Output(every=0.05, times=(0.012,), fields=("u", "p"), probe_interval=0.001).fields
    ('u', 'p')
    """

    every: float | None = Field(default=None, gt=0, description="time between snapshots [s]")
    times: Several[Annotated[float, Field(ge=0)]] = Field(default=(), description="times of further snapshots [s]")
    fields: Several[str] = Field(default=("u", "p", "role"), description="names of fields in snapshots")
    checkpoint_every: float | None = Field(default=None, gt=0, description="simulated time between checkpoints [s]")
    probe_every: int = Field(default=1, ge=1, description="steps between samples of the probes")
    probe_interval: float | None = Field(default=None, gt=0, description="time between samples of the probes [s]")
    budget: bool = Field(default=False, description="whether the energy gained by each part of a step is written")

    @field_validator("fields")
    @classmethod
    def _known_fields(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        known = [field.name for field in FIELDS.values() if field.written]
        for name in names:
            _known("field", name, known)
        return tuple(dict.fromkeys(names))

    @model_validator(mode="after")
    def _one_rate(self) -> "Output":
        if self.probe_interval is not None and self.probe_every != 1:
            raise ValueError(
                f"probe_every = {self.probe_every} and probe_interval = {self.probe_interval:g} s: "
                "give only one of them, samples are taken every so many steps or at a fixed rate in time"
            )
        return self


def _known(what: str, name: str, names: Iterable[str]) -> str:
    if name not in names:
        raise ValueError(f"unknown {what} {shown(name)}; known are {', '.join(names)}")
    return name
