"""The presets: a dictionary of names and numbers for each kind of flow."""

from typing import Any

WITHOUT_FILMS = ("filter", "collisions", "wall_guard", "projection", "parting", "shift", "keep_apart")

# Defaults of all presets.
USUAL: dict[str, Any] = {
    "divergence": "flux",
    "source": "mixed",
    "forces": ("body", "coriolis", "viscous", "absorb", "friction"),
    "regularisers": ("film", *WITHOUT_FILMS),
    "zeta": 1.0,
    "zeta_time": 0.0,
    "gamma": 0.0,
    "strain": 1.0,
    "kappa": 0.8,            # tuned 0.4 to 1.6: greatest weight of the position projection; measured
    "kappa_strain": 56.0,    # tuned 28 to 112: weight of the projection over the strain of a step; measured
    "collision_distance": 0.7,    # tuned 0.35 to 1: distance of pairs that collide, in spacings; judged
    "restitution": 0.2,      # tuned 0.1 to 0.4: of these collisions; judged
    "wall_guard": 0.25,      # tuned 0.125 to 0.5: distance from a wall that particles keep, in spacings; judged
}

# Waves that do not break. The wall guard changes no wave. Without it, a surface particle that moves up and down beside
# a wall finally passes through it.
_GENTLE: dict[str, Any] = {
    **USUAL,
    "regularisers": ("irrotational", "collisions", "wall_guard", "fill_voids", "shift_even"),
    "cfl": 0.4,    # tuned 0.2 to 0.8: largest move of a particle in a step, in spacings; judged
    "fall": 0.0,
    "wave_step": 0.5,    # tuned 0.25 to 0.76: largest step over sqrt(s/g); measured
    "residual_strain": 0.0,
    "volume_time": 10.0,    # tuned 5 to 20: time over sqrt(s/g) that gives volume back; measured
    # With half of these, surface particles crowd before a flap, and pairs of them end a run: H/d = .1, d/s = 16, in
    # period 26. With these, none is closer than .56 s in 40 periods. A standing wave loses no more height.
    "shift": 0.4,    # tuned 0.2 to 0.8: greatest weight of the even shift; measured
    "shift_strain": 56.0,    # tuned 28 to 112: weight of the even shift over the strain of a step; measured
    "filter": 0.5,    # tuned 0.25 to 1: part of the roughness that is removed over sqrt(s/a); measured
    "filter_strain": 0.0,
    "surface_rule": "gap",
    "surface_offset": 0.0,
    "pressure_mean": 0.0,
    "wall_rows": "curved",
    "gradient": "cubic",
    "surface_gradient": "same",
    "stepping": "corrected",
    "rtol": 1e-9,    # tuned 5e-10 to 2e-9: of the pressure solve; judged
}

PRESETS: dict[str, dict[str, Any]] = {
    # Breaking waves and impacts: a moving free surface, regularised particles.
    "violent": {
        **USUAL,
        "regularisers": ("film", "filter", "irrotational", *WITHOUT_FILMS[1:]),
        "cfl": 0.8,    # tuned 0.4 to 1.6: largest move of a particle in a step, in spacings; measured
        "fall": 0.05,    # tuned 0.025 to 0.1: largest step over sqrt(l/a); measured
        "wave_step": 0.0,
        "residual_strain": 100.0,    # tuned 50 to 200: residual divergence removed over the strain of a step; measured
        "volume_time": 0.0,
        "shift": 0.2,    # tuned 0.1 to 0.4: greatest weight of the Fick shift; measured
        "shift_strain": 28.0,    # tuned 14 to 56: weight of the Fick shift over the strain of a step; measured
        "filter": 0.1,    # tuned 0.05 to 0.2: greatest part of the roughness that a step removes; measured
        "filter_strain": 1.4,    # tuned 0.7 to 2.8: fraction of roughness over the strain of a step; measured
        "surface_rule": "gap",
        "surface_offset": 0.6,    # tuned 0.3 to 1: distance of p = 0 from full surface particles, in layers; measured
        "pressure_mean": 1.0,    # tuned 0.5 to 2: time of means of pressure probes; measured
        "wall_rows": "sfdi",
        "gradient": "mixed",
        "surface_gradient": "harmonic",
        "stepping": "midpoint",
        "rtol": 1e-5,    # tuned 5e-6 to 2e-5: of the pressure solve; measured
    },
    # A closed tank full of viscous fluid: only positions are regularised, by a shift in proportion to strain. A
    # position projection would make cells more equal, but takes a quarter of the energy of the flow in a cavity at
    # Re = 400. Inviscid fluid gains energy, as velocities do not follow the shift: a vortex of 20 x 20 particles 26 %
    # in 5 s. With the corrected gradient, errors of u and v in the cavity are 1.9 and 0.9 % with 40 x 40 particles,
    # else 2.1 and 1.1 %.
    "closed": {
        **USUAL,
        "regularisers": ("wall_guard", "projection", "parting", "shift_tensile", "keep_apart"),
        "cfl": 0.25,
        "fall": 0.0,
        "wave_step": 0.0,
        "residual_strain": 0.0,
        "volume_time": 0.0,
        "kappa": 0.0,
        "shift": 0.2,
        "shift_strain": 12.0,
        "filter": 0.0,
        "filter_strain": 0.0,
        "collision_distance": 0.0,
        "restitution": 0.0,
        "surface_rule": "none",
        "surface_offset": 0.0,
        "pressure_mean": 0.0,
        "wall_rows": "sfdi",
        "gradient": "corrected",
        "surface_gradient": "same",
        "stepping": "midpoint",
        "rtol": 1e-6,
    },
    "gentle": _GENTLE,
    "solitary": _GENTLE,    # name in older cases
}

# Values of the violent preset in a full tank with a lid. Without a free surface, where stencils are one-sided, weaker
# regularisation keeps particles regular, and a vortex keeps its energy. If the tank only translates, fluid in it moves
# by the error of the solver alone.
CLOSED = {
    "regularisers": USUAL["regularisers"],
    "surface_rule": "none",
    "residual_strain": 0.0,
    "kappa": 0.65,
    "kappa_strain": 70.0,
    "shift": 0.06,
    "shift_strain": 6.0,
    "filter": 0.05,
    "filter_strain": 0.7,
    "rtol": 1e-6,
}


def preset_values(preset: str, closed: bool) -> dict[str, Any]:
    """Return the values of a preset; closed : whether the fluid fills a tank with a lid."""
    own = CLOSED if preset == "violent" else {"surface_rule": CLOSED["surface_rule"]}
    return {**PRESETS[preset], **(own if closed else {})}
