"""The words by which a case names a method and its parts.

A case is described and checked without the code that runs it, so it needs only the words. Registries (methods.parts)
hold the parts. A part that is registered from outside the package adds its word here.
"""

WORDS: dict[str, list[str]] = {
    "laplacian": ["rankine", "rankine_printed", "sph", "cisph1", "cisph2", "gfd", "rankine_quadratic", "fatehi"],
    "divergence": ["flux", "nodal"],
    "gradient": ["sfdi", "symmetric", "mixed", "spline", "corrected", "curved", "cubic"],
    "surface_gradient": ["same", "harmonic", "curved"],
    "wall_rows": ["sfdi", "harmonic", "curved", "curved_breaking"],
    "surface_rule": ["gap", "auxiliary", "density", "divergence", "frozen", "none"],
    "source": ["mixed", "divergence", "density", "compensating"],
    "stepping": ["midpoint", "corrected", "start", "predicted", "symplectic"],
    "force": ["body", "coriolis", "viscous", "viscous_morris", "absorb", "friction"],
    "regulariser": ["film", "filter", "irrotational", "collisions", "wall_guard", "projection", "parting", "shift",
                    "keep_apart", "fill_voids", "shift_even", "shift_tensile", "shift_xu", "shift_lind",
                    "shift_pressure"],
    "probe": [],    # those of the package are found by their files (case.probes)
}

# Features of a scene that need certain forces.
PHYSICS = {
    "viscous": "viscosity of the fluid or of eddies", "turning": "a tank that turns",
    "absorbing": "zones that absorb waves", "friction": "friction on walls",
}

_OURS = {what: tuple(words) for what, words in WORDS.items()}


def outside() -> list[str]:
    """Return the words of parts that were registered from outside the package."""
    return [word for what, words in WORDS.items() for word in words if word not in _OURS[what]]


def known(what: str) -> tuple[str, ...]:
    """Return the words for one kind of part, the built-in ones first."""
    return tuple(WORDS[what])


def add(what: str, word: str) -> None:
    """Add the word of a part that is registered. No effect if it is known."""
    if word not in WORDS[what]:
        WORDS[what].append(word)
