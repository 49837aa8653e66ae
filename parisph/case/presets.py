"""Known methods, and the presets: one dictionary of numbers for each kind of flow."""

# The pressure rows by the papers' names. ISPH: Z14 Eq 20a; ISPH_R: Z14 Eq 23, normalised so that it
# converges; ISPH_R_printed: as printed, for comparison only (it does not converge).
METHODS = ("ISPH_R", "ISPH", "ISPH_R_printed")

PRESETS = {
    # Breaking waves and impacts: a moving free surface, regularised particles.
    "violent": {
        "zeta": 1.0,
        "zeta_time": 0.0,
        "gamma": 0.0,
        "strain": 1.0,
        "kappa": 0.2,
        "shift": 0.3,
        "filter": 0.03,
        "collision_distance": 0.85,
        "restitution": 0.2,
        "wall_guard": 0.5,
        "surface_rule": "gap",
        "wall_rows": "sfdi",
        "gradient": "sfdi",
        "surface_gradient": "same",
        "stepping": "midpoint",
        "rtol": 1e-6,
    },
    # Waves that do not break: the surface keeps its particles, and stencils are exact for harmonic pressure.
    "gentle": {
        "zeta": 1.0,
        "zeta_time": 0.0,
        "gamma": 0.0,
        "strain": 1.0,
        "kappa": 0.0,
        "shift": 0.0,
        "filter": 0.03,
        "collision_distance": 0.0,
        "restitution": 0.0,
        "wall_guard": 0.0,
        "surface_rule": "frozen",
        "wall_rows": "harmonic",
        "gradient": "mixed",
        "surface_gradient": "harmonic",
        "stepping": "midpoint",
        "rtol": 1e-9,
    },
}
