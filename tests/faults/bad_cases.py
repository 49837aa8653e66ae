"""Case files that are wrong by construction: a good one with one thing changed that no case may have."""

from tests.faults.attempt import Attempt

GOOD = """
from math import inf, nan, pi
from parisph import Box, Case, Energy, Fluid, Numerics, Output, PressureTap, SurfaceGauge, Sway, Tabulated, Tank, Truth

def case() -> Case:
    return Case(
        title={title},
        fluid=Fluid(Box(width={width}, height={height}, at={at}), density={density}, velocity={velocity},
                    elevation={elevation}),
        walls=Tank(width={tank_width}, height={tank_height}, lid={lid}, at={tank_at}),
        gravity={gravity},
        frame={frame},
        numerics=Numerics(spacing={spacing}, method={method}, preset={preset}, time_step={time_step}, cfl={cfl},
                          max_time_step={max_time_step}, gamma={gamma}, kappa={kappa}, shift={shift}, filter={filter},
                          kappa_strain={kappa_strain}, shift_strain={shift_strain}, filter_strain={filter_strain},
                          residual_strain={residual_strain}, volume_time={volume_time},
                          pressure_mean={pressure_mean}, fall={fall}, surface_offset={surface_offset},
                          collision_distance={collision_distance}, wall_guard={wall_guard}, surface_rule={surface_rule},
                          gradient={gradient}, stepping={stepping}, rtol={rtol}, jitter={jitter},
                          jitter_surface={jitter_surface}, seed={seed}),
        output=Output(every={every}, times={times}, fields={fields}, checkpoint_every={checkpoint_every},
                      probe_every={probe_every}),
        probes={probes},
        end_time={end_time},
    )
"""
VALUES = {
    "title": "'good'", "width": "1.0", "height": "0.5", "at": "(0.0, 0.0)", "density": "1000.0",
    "velocity": "(0.0, 0.0)", "elevation": "None", "tank_width": "2.0", "tank_height": "1.0", "lid": "True",
    "tank_at": "(0.0, 0.0)", "gravity": "(0.0, -9.81)", "frame": "Sway(amplitude=0.01, frequency=2.0)",
    "spacing": "0.1", "method": "'ISPH_R'", "preset": "'violent'", "time_step": "None", "cfl": "0.4",
    "max_time_step": "0.01", "gamma": "0.0", "kappa": "0.2", "shift": "0.3", "filter": "0.1",
    "collision_distance": "0.7", "kappa_strain": "56.0", "shift_strain": "28.0", "filter_strain": "1.4",
    "residual_strain": "100.0", "volume_time": "30.0", "pressure_mean": "1.0", "fall": "0.05", "surface_offset": "0.5",
    "wall_guard": "0.25", "surface_rule": "'gap'", "gradient": "'sfdi'", "stepping": "'midpoint'", "rtol": "1e-6",
    "jitter": "0.0",
    "jitter_surface": "False", "seed": "0", "every": "0.1", "times": "(0.2,)", "fields": "('u', 'p')",
    "checkpoint_every": "0.5", "probe_every": "1", "probes": "[Energy('energy'), PressureTap('tap', at=(0.0, 0.1))]",
    "end_time": "1.0",
}

# What no field may hold, and then what fields of one kind may not.
NOTHING = ("nan", "inf", "-inf", "object()", "lambda: 1", "{}", "...", "1j", "b'1'", "10**400", "-10**5000", "1e300",
           "-1e200", "[[[[]]]]")
NUMBER = (*NOTHING, "True", "'1.0'", "'wide'", "'x'*100000", "(1.0,)", "[]", "Energy('a')")
POSITIVE = (*NUMBER, "0", "-1.0", "-5e-324", "5e-324", "1e-200")
NEEDED = (*POSITIVE, "None")
TEXT = ("1", "True", "None", "nan", "b'a'", "['a']", "object()", "''", "'a\\nb'", "'\\x1b[31m'", "'\\0'", "'\\u2028'",
        "'x'*100000", "'\\ud800'")
WORD = (*TEXT, "'no such'", "'ISPH '")
FLAG = ("1", "0", "'yes'", "None", "nan", "[]", "2.5", "1e300", "()")
WHOLE = ("-1", "1.5", "nan", "True", "'1'", "10**31", "10**5000", "None", "[]", "-1e300")
POINT = ("None", "1.0", "'x'", "(1.0,)", "(0.0, 0.0, 0.0)", "(0.0, nan)", "(0.0, 1e300)", "(0.0, True)", "(0.0, '1')",
         "()", "(0.0,)*1000", "({}, 0)")
VECTOR = ("None", "1.0", "'x'", "(0.0,)", "(0.0, 0.0, 0.0)", "(0.0, nan)", "(0.0, 1e300)", "(0.0, True)", "(0.0, 'q')",
          "(0.0, 'x.real')", "(0.0, '')", "(0.0, '__import__(\"os\").abort()')", "(0.0, 'x+'*900 + 'x')",
          "(0.0, '('*300)", "(0.0, '1e200')", "(0.0, '1/(x-x)')", "(0.0, 'sqrt(-1)')", "(0.0, '9**9**9')",
          "(0.0, 'a\\nb')", "(0.0, 'sin(x')", "(0.0, 'sin')", "(0.0, 'lambda: 1')", "(0.0,)*100000", "((1, 2), 3)")
FRAME = ("None", "'sway'", "Sway(0.1, 0.0)", "Sway(0.1, -1.0)", "Sway(nan, 1.0)", "Sway(0.1, 1e300)", "Sway(1.0, 1e9)",
         "Sway(1e-9, 1e15)", "Sway(0.1, True)", "Sway(0.1, 1.0, (0.0, 0.0))", "Sway(0.1, 1.0, (1.0, 0.0, 0.0))",
         "Sway(0.1, 1.0, (1e-320, 0.0))", "Tabulated((0, 1), (0, 1))", "Tabulated((0, 1, 1, 2), (0, 0, 0, 0))",
         "Tabulated((0, 1, 2, 3), (0, 0, 0))", "Tabulated((0, 1, 2, nan), (0, 0, 0, 0))",
         "Tabulated((0, 1e-300, 1, 2), (0, 1, 0, 0))", "Tabulated((0, 1e-12, 1, 2), (0, 1, 0, 0))", "{'kind': 'roll'}",
         "[]", "True")
PROBES = ("None", "1", "'energy'", "Energy('a')", "[1]", "['energy']", "[None]", "[Energy('a'), Energy('a')]",
          "[Energy('../a')]", "[Energy('a\\nb')]", "[Energy('')]", "[Energy('x'*9999)]", "[Energy(3)]",
          "[PressureTap('a', at=(0.5, 0.5))]", "[PressureTap('a', at=(0.0,))]", "[PressureTap('a', at=(0.0, nan))]",
          "[PressureTap('a', at=(0.0, 0.1), radius=0.0)]", "[PressureTap('a', at=(0.0, 0.1), radius=nan)]",
          "[SurfaceGauge('a', at=9.0)]", "[SurfaceGauge('a', at=True)]", "[{'kind': 'salt', 'name': 'a'}]",
          "[Energy('a', truth=Truth('no.csv', 't', 'v'))]", "[Energy('a', truth=Truth('/dev/zero', 't', 'v'))]",
          "[Energy('a', truth='no.csv')]", "[Energy('a', truth=Truth('.', 't', 'v'))]",
          "[Energy('a', truth=Truth('x'*999, 't', 'v'))]", "[Energy('a', truth=Truth('a\\nb', 't', 'v'))]",
          "[Energy('a')]*100000", "({},)", "[Energy('a', truth=Truth('t.csv', 't', 'v', time_scale=0.0))]")
OWN = {    # beside those of the kind; what is said then names the field, or what stands behind ->
    "title": ("'x'*201",), "width": ("0.97", "3.0 -> fluid.shape"), "height": ("0.97", "1.1 -> fluid.shape"),
    "spacing": ("1e-9", "0.13", "7.0", "0.1001"),
    "tank_width": ("2.01", "1e12 -> spacing", "1e8+0.05"), "tank_height": ("1e30 -> spacing", "0.1 -> fluid.shape"),
    "cfl": ("2.1", "1e-12 -> steps"), "gamma": ("-0.1", "1.1"), "kappa": ("-1", "2.5"),
    "shift": ("-1", "9.0"), "filter": ("-0.1", "1.5"), "collision_distance": ("-1", "2.1"), "kappa_strain": ("-1",),
    "shift_strain": ("-1",), "filter_strain": ("-1",), "residual_strain": ("-1",), "volume_time": ("-1",),
    "pressure_mean": ("-1", "101"), "fall": ("-1", "3"), "surface_offset": ("-1", "2"), "wall_guard": ("-0.5", "3.0"),
    "rtol": ("1.0", "2"),
    "jitter": ("-0.1", "1.3"), "time_step": ("0.001",), "max_time_step": ("2.0", "1e-12"), "every": ("1e-12",),
    "checkpoint_every": ("1e-12",),
    "end_time": ("1e20 -> steps", "0.1 -> output.times"),
    "times": ("(2.0,)", "(-1.0,)", "(True,)", "('1',)", "(nan,)", "(2.0,)*10000", "(0.0,)*1000001", "3.0"),
    "fields": ("('v',)", "(1,)", "None", "('u', 'x'*9999)", "'v'", "7"),
    "elevation": ("0.7", "'0.6*x'", "'y'", "'1/x'", "''", "'q'", "-0.4"),
    "at": ("(1e17, 0.0) -> walls|fluid.shape", "(1.5, 0.0) -> fluid.shape", "(-0.1, 0.0) -> fluid.shape",
           "(0.05, 0.0) -> fluid.shape"),
    "tank_at": ("(1e17, 0.0) -> walls|fluid.shape", "(0.5, 0.0) -> fluid.shape"),
    "velocity": ("('1e12', 0.0) -> steps", "('t', 0.0)"),
    "gravity": ("('1e29', 0.0) -> steps", "('z', 0.0)"), "seed": ("2**63",), "probe_every": ("0",),
}
KINDS = {
    NEEDED: "width height density tank_width tank_height spacing end_time",
    POSITIVE: "rtol every checkpoint_every max_time_step time_step",
    NUMBER: "gamma kappa shift filter kappa_strain shift_strain filter_strain residual_strain volume_time "
            "pressure_mean fall surface_offset collision_distance wall_guard jitter", TEXT: "title",
    WORD: "method preset surface_rule gradient stepping", FLAG: "lid jitter_surface", WHOLE: "seed probe_every",
    POINT: "at tank_at",
    VECTOR: "velocity gravity", FRAME: "frame", PROBES: "probes", (*NOTHING, "True"): "times fields elevation",
}
KIND = {name: values for values, names in KINDS.items() for name in names.split()}
MAY_BE_NONE = {"surface_rule", "gradient", "stepping"}
SAID = {"tank_width": "width", "tank_height": "height", "tank_at": "at|walls", "at": "at|fluid.shape",
        "probes": "probe|Energy|Truth|Tap|Gauge|truth", "frame": "frame|Sway|Tabulated|times|values",
        "gradient": "gradient", "spacing": "spacing", "tank": "walls", "time_step": "time_step"}

# Whole files: what is in them, and what a message must say.
FILES = {
    "def case(\n": "syntax error", "": "no function case", "case = 3\n": "int", "case = {}\n": "dict",
    "def case():\n    return {}\n": "dict",
    "def case():\n    pass\n": "NoneType", "def case(a):\n    pass\n": "'a'", "def case(*a):\n    pass\n": "*a",
    "def case(a, /):\n    pass\n": "a",
    "async def case():\n    pass\n": "plain function", "def case():\n    yield\n": "generator",
    "class case:\n    pass\n": "returned a case",
    "from parisph import Case as case\n": "cannot be set by name",
    "import functools\ncase = functools.partial(print)\n": "case", "case = len\n": "case",
    "1/0\n": "ZeroDivisionError", "raise SystemExit\n": "SystemExit",
    "raise BaseException('x'*9999)\n": "BaseException",
    "def case():\n    raise GeneratorExit\n": "GeneratorExit",
    "class E(BaseException):\n    pass\ndef case():\n    raise E\n": "line 4",
    "class E(Exception):\n    def __str__(self):\n        raise self\nraise E\n": "line 4",
    "def case():\n    return case()\n": "RecursionError",
    "raise MemoryError\n": "MemoryError", "raise ValueError('a\\nparisph: error: b\\n'*999)\n": "ValueError",
    "import nowhere_at_all\n": "nowhere_at_all",
    "from parisph import nothing\n": "nothing", "from parisph import *\n": "no function case",
    "raise UnicodeDecodeError('utf-8', b'a', 0, 1, 'x')\n": "UnicodeDecodeError",
    "x = [0] * (1 << 62)\n": "MemoryError", "raise OSError(2, 'gone', 'a\\nb')\n": "gone", "(" * 3000: "bad_case.py",
    "x = '\0'\n": "not text",
    "from parisph import CaseError\nraise CaseError('y\\n'*5000)\n": "more problems",
    "raise StopIteration\n": "StopIteration",
    "class R:\n    def __repr__(self):\n        raise ValueError\ndef case(a: int = R()):\n"
    "    return a\n": "returned a R",
    "raise ExceptionGroup('many', [ValueError()])\n": "bad_case.py",
    "assert False, '\\x1b[2J\\x07'\n": "AssertionError",
    "\udcff\udcfe": "bad_case.py", "import os\nos.chdir('/nowhere')\n": "/nowhere",
    "def case():\n    return open('/nowhere')\n": "/nowhere",
}


def source(**changes):
    """Return the text of the good case file with other values."""
    return GOOD.format(**{**VALUES, **changes})


def field(random, number):
    """A field with a value that it may not have."""
    names = sorted(VALUES)
    name = names[number % len(names)]
    own = OWN.get(name, ())
    values = [value for value in KIND[name] if not (value == "None" and name in MAY_BE_NONE)]
    value, _, said = str(random.choice([*values, *own])).partition(" -> ")
    verb = "run" if random.random() < 0.3 else "check"
    return Attempt(f"{name} = {value}", [verb, "bad_case.py"], (said or SAID.get(name, name)).split("|"),
                   {"bad_case.py": source(**{name: value})})


def file(random, number):
    """A whole case file that is none."""
    texts = sorted(FILES)
    text = texts[number % len(texts)]
    verb = "run" if random.random() < 0.3 else "check"
    return Attempt(f"case file {text[:60]!r}", [verb, "bad_case.py"], [FILES[text]], {"bad_case.py": text})


def mutated(random, number):
    """A good case file without one of its brackets, or with a name in it misspelt."""
    text = source()
    if number % 2:
        brackets = [place for place, character in enumerate(text) if character in "()[]"]
        place = int(random.choice(brackets))
        return Attempt(f"case file without its bracket at {place}", ["check", "bad_case.py"], ["syntax error"],
                       {"bad_case.py": text[:place] + text[place + 1:]})
    names = [name for name in ("title=", "width=", "density=", "gravity=", "spacing=", "Case(", "Box(", "Tank(",
                               "Fluid(", "end_time=", "probes=", "Energy(")]
    name = str(random.choice(names))
    return Attempt(f"case file with {name} misspelt", ["check", "bad_case.py"], [f"{name[:-1]}_"],
                   {"bad_case.py": text.replace(name, f"{name[:-1]}_{name[-1]}", 1)})
