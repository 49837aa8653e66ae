"""Command lines that are wrong by construction. 'good.py' is a sound case, and '{run}' the folder of a sound run."""

from tests.faults.attempt import Attempt

NAMES = ("", " ", "a\nb", "a\rb", "\x1b[2J", "x" * 300, "x" * 100_000, "x/" * 3000, "a\0b", "\udcff", "\ud800",
         "\u2028")
NUMBERS = ("nan", "inf", "-inf", "1e999", "1e300", "late", "", "1/2", "0x10", "1 2", "x" * 10_000, "--", "1e", "١e٩٩٩")
SETS = ("spacing", "spacing=", "=1", "=", "", "spacing=nan", "spacing=inf", "spacing=-1", "spacing=0", "spacing=wide",
        "spacing=1e300", "spacing=0.13", "spacing=" + "9" * 10_000, "spacing=__import__('os').abort()", "spacing=1/0",
        "spacing=(1", "spacing=1e-12", "spacing=true", "spacing=1,2", "nothing=1", "x" * 100_000 + "=1", "title=",
        "title=" + "x" * 10_000, "title=a\nb", "title=\x1b[2J", "lid=maybe", "lid=2", "n=1.5", "n=" + "9" * 10_000,
        "n=wide", "at=1", "at=1,2,3", "at=a,b", "at=nan,0", "at=", "Spacing=0.1", "spacing =", "odd=1",
        "spacing=9**9**9", "end_time=-1", "end_time=1e30", "spacing=\udcff")
# verb and its words; and what must be said
LINES = (
    ([], "VERB"), (["swim"], "swim"), (["x" * 100_000], "invalid choice"), (["\x1b[2J"], "argument"), ([""], "VERB"),
    (["run"], "CASE"), (["check"], "CASE"), (["restart"], "DIR"), (["info"], "DIR"), (["plot"], "DIR"),
    (["movie"], "DIR"), (["compare"], "DIR"), (["compare", "{run}"], "REFERENCE"),
    (["check", "good.py", "more"], "more"), (["check", "good.py", "--sets", "spacing=1"], "--sets"),
    (["check", "good.py", "--set"], "--set"), (["check", "good.py", "-o", "out"], "-o"),
    (["check", "good.py", "--", "-pressure_ksp_view"], "PETSc"), (["check", "good.py", "--x" + "y" * 100_000], "--x"),
    (["run", "good.py", "-pressure_ksp_view"], "--"), (["run", "good.py", "-log_view"], "PETSC_OPTIONS"),
    (["run", "good.py", "--", "-log_view"], "PETSC_OPTIONS"),
    (["run", "good.py", "--", "--set", "spacing=0.05"], "--set"), (["run", "good.py", "--", "-o", "out"], "-o"),
    (["run", "good.py", "--", "--" + "x" * 9999], "--"), (["run", "good.py", "--until", "3"], "--until"),
    (["run", "."], "folder"), (["run", "/dev/null"], "/dev/null"), (["run", "no.py"], "no.py"),
    (["run", "good.py/x"], "good.py"), (["check", "/proc/self/mem"], "mem"),
    (["check", "good.py", "--set", "spacing=0.1", "spacing=0.2"], "twice"),
    (["restart", "{run}", "--until", "-1"], "end_time"), (["restart", "{run}", "--until", "0"], "end_time"),
    (["restart", "{run}", "--until", "1e20"], "end_time"), (["restart", "{run}", "--until", "0.01"], "end_time"),
    (["restart", "{run}", "--set", "spacing=1"], "--set"), (["restart", "no"], "no"),
    (["restart", "good.py"], "good.py"), (["restart", "/dev/zero"], "/dev/zero"), (["restart", "{run}"], "--until"),
    (["restart", "{run}", "--until", "1", "-o", "good.py"], "good.py"),
    (["restart", "{run}", "--until", "1", "-o", "good.py/x"], "good.py"),
    (["run", "good.py", "-o", "good.py"], "good.py"), (["run", "good.py", "-o", "good.py/x/y"], "good.py"),
    (["run", "good.py", "-o", "/proc/run"], "/proc/run"), (["run", "good.py", "-o", "{run}"], "holds a run"),
    (["run", "good.py", "--", "-pressure_ksp_type", "salt"], "salt"),
    (["run", "good.py", "--", "-pressure_pc_type", "salt"], "salt"),
    (["run", "good.py", "--", "-pressure_ksp_rtol", "10"], "rtol"),
    (["run", "good.py", "--", "-pressure_ksp_rtol", "nan"], "rtol"),
    (["run", "good.py", "--", "-pressure_ksp_rtol", "x"], "rtol"),
    (["plot", "{run}", "--time", "0.01", "--peak", "P2"], "--peak"), (["plot", "{run}", "--peak", "P9"], "P9"),
    (["plot", "{run}", "--probe", "P9"], "P9"), (["plot", "{run}", "--probe", ""], "probe"),
    (["plot", "{run}", "--probe", "x" * 100_000], "probe"), (["plot", "{run}", "--field", "salt"], "salt"),
    (["plot", "{run}", "--field", ""], "quantity"), (["plot", "{run}", "--field", "x" * 100_000], "quantity"),
    (["plot", "{run}", "--normalise"], "--normalise"), (["plot", "{run}", "-o", "no/p.png"], "no/p.png"),
    (["plot", "{run}", "-o", "p.salt"], "p.salt"), (["plot", "{run}", "-o", "."], "."),
    (["plot", "{run}", "-o", "good.py/p.png"], "good.py"), (["plot", "{run}", "-o", "/proc/p.png"], "/proc/p.png"),
    (["plot", "{run}", "-o", "there"], "there"), (["plot", "{run}", "-o", "p"], "p"),
    (["plot", "{run}", "-o", "p."], "p."), (["plot", "{run}", "--time", "0", "--probe", "P2", "-o", "p.png"], "-o"),
    (["plot", "{run}", "--time", "0", "-o", "no/p.png"], "no/p.png"),
    (["plot", "{run}", "--probe", "P2", "-o", "p.salt"], "p.salt"), (["movie", "{run}", "-o", "m.salt"], "m.salt"),
    (["movie", "{run}", "-o", "no/m.gif"], "no/m.gif"), (["movie", "{run}", "-o", "m"], "m"),
    (["movie", "{run}", "--field", "salt"], "salt"), (["movie", "{run}", "--time", "1"], "--time"),
    (["movie", "{run}", "-o", "good.py/m.gif"], "good.py"), (["movie", "{run}", "-o", "there/"], "there"),
    (["plot", "{run}", "--limits", "2", "1", "--time", "0"], "--limits"),
    (["plot", "{run}", "--limits", "1"], "--limits"), (["plot", "{run}", "--zoom", "0", "1"], "--zoom"),
    (["plot", "{run}", "--zoom", "1", "0", "0", "1", "--time", "0"], "--zoom"),
    (["plot", "{run}", "--zoom", "0", "nan", "0", "1"], "--zoom"),
    (["plot", "{run}", "--cmap", "salt", "--time", "0"], "salt"),
    (["plot", "{run}", "--cmap", "x" * 100_000, "--time", "0"], "colour map"),
    (["plot", "{run}", "{run}", "--time", "0"], "several runs"), (["plot", "{run}", "no"], "no"),
    (["plot", "{run}", "{run}", "--probe", "P9"], "P9"), (["movie", "{run}", "--fps", "0"], "fps"),
    (["movie", "{run}", "--fps", "-1"], "fps"), (["movie", "{run}", "--fps", "1e9"], "fps"),
    (["movie", "{run}", "--slow", "0"], "slow"), (["movie", "{run}", "--slow", "1e20"], "slow"),
    (["movie", "{run}", "--limits", "2", "1"], "--limits"), (["movie", "{run}", "--cmap", "salt"], "salt"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--plot", "p"], "p"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--plot", "no/p.png"], "no/p.png"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--plot", "p.salt"], "p.salt"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--plot", ""], "--plot"),
    (["compare", "{run}", "no.csv", "--probe", "P2"], "no.csv"), (["compare", "{run}", ".", "--probe", "P2"], "."),
    (["compare", "{run}", "/dev/zero", "--probe", "P2"], "/dev/zero"), (["compare", "{run}", "ref.csv"], "--probe"),
    (["compare", "{run}", "ref.csv", "--probe", "P9"], "P9"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--column", "q"], "'q'"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--time", "q"], "--time"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--value", "q"], "--value"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--value", ""], "--value"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--best-shift", "-1"], "best_shift"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--time-scale", "0"], "time_scale"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--time-scale", "-1"], "time_scale"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--shift", "1e20"], "share fewer"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--best-shift", "1e20"], "fewer than two"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--scale", "1e30"], "scale"),
    (["compare", "{run}", "ref.csv", "--probe", "P2", "--offset", "1e31"], "--offset"), (["doctor", "more"], "more"),
    (["doctor", "--trials"], "--trials"), (["completion"], "SHELL"), (["completion", "salt"], "salt"),
)
GOOD = """
from parisph import Box, Case, Fluid, Numerics, Tank
def case(spacing: float = 0.1, title: str = "good", lid: bool = False, n: int = 3,
         at: tuple[float, float] = (0.0, 0.0), odd: dict = {}, end_time: float = 1.0) -> Case:
    return Case(title=title, fluid=Fluid(Box(1.0, 0.5), density=1000.0), walls=Tank(1.0, 1.0, lid, at),
                gravity=(0.0, -9.81), numerics=Numerics(spacing=spacing), end_time=end_time)
"""
FILES = {"good.py": GOOD, "ref.csv": "t,pressure\n0,1\n0.05,2\n0.1,4\n", "there": None}
WITH_NAMES = (["run", "{}"], ["check", "{}"], ["run", "good.py", "-o", "{}"], ["restart", "{}"],
              ["restart", "{run}", "--until", "1", "-o", "{}"], ["info", "{}"], ["plot", "{}"],
              ["plot", "{run}", "-o", "{}"], ["movie", "{}"], ["movie", "{run}", "-o", "{}"],
              ["compare", "{}", "ref.csv"], ["compare", "{run}", "{}"], ["plot", "{run}", "{}"],
              ["compare", "{run}", "ref.csv", "--probe", "P2", "--plot", "{}"])
WITH_NUMBERS = (["restart", "{run}", "--until"], ["plot", "{run}", "--time"], ["movie", "{run}", "--fps"],
                ["movie", "{run}", "--slow"], *(
                    ["compare", "{run}", "ref.csv", "--probe", "P2", option]
                    for option in ("--offset", "--scale", "--time-scale", "--shift", "--best-shift", "--rest")))


def line(random, number):
    """A whole command line."""
    words, says = LINES[number % len(LINES)]
    return Attempt(_shown(words), words, [says], FILES, codes=(2, 5))


def name(random, number):
    """A name that no file can have, wherever one is asked for."""
    words, bad = WITH_NAMES[number % len(WITH_NAMES)], NAMES[int(random.integers(len(NAMES)))]
    words = [word.replace("{}", bad) if word == "{}" else word for word in words]
    return Attempt(_shown(words), words, ["argument"], FILES)


def long_name(random, number):
    """A long name that a file could have, of what is not there."""
    words = [word for word in WITH_NAMES if word[0] != "run" and "-o" not in word and "--plot" not in word]
    words, bad = words[number % len(words)], ("y/" * 1900, "y" * 250, "./" * 1900 + "y",
                                              "é" * 120)[int(random.integers(4))]
    return Attempt(_shown([word.replace("{}", bad) for word in words]), [word.replace("{}", bad) for word in words],
                   ["y", "é"], FILES, codes=(2, 5))


def value(random, number):
    """What is no number, wherever one is asked for."""
    words, bad = WITH_NUMBERS[number % len(WITH_NUMBERS)], NUMBERS[int(random.integers(len(NUMBERS)))]
    return Attempt(_shown([*words, bad]), [*words, bad], [words[-1], "argument"], FILES)


def setting(random, number):
    """A value for a parameter of the case file that it cannot have."""
    text = SETS[number % len(SETS)]
    verb = "run" if random.random() < 0.3 else "check"
    names = [text.partition("=")[0].strip() or "--set", "--set", "argument", "title", "spacing", "no parameter"]
    return Attempt(f"--set {text[:60]!r}", [verb, "good.py", "--set", text], names, FILES)


def _shown(words):
    return " ".join(word if len(word) < 60 else word[:60] + "..." for word in words)
