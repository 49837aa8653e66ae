"""Dam breaks beside measured pressures and converged codes, with their CPU seconds; without the data there are none."""

from functools import partial

from parisph.case.measured_data import measured
from parisph.study import Function, Required, Study, TruthError, Variant
from tests.validation import record

DATA = "02c_lobovsky2014_H300_pressure_event.csv"
CODES = ("weakly compressible SPH, H/s = 400", "EDAC-SPH, H/s = 400")
SENSORS = {"S1": 0.43, "S2": 0.30, "S3": 0.26, "S4": 0.35}    # what others with converged codes have
PEAK = "greatest pressure at S2, part by which it is outside the band"


def rows(bench):
    """Return the errors against converged codes and an event, and where the peak at S2 is, as required."""
    if measured(DATA, "") is None:
        print("  not run: the measured data is not there, see cases/README.md", flush=True)
        return []
    found = []
    for what, study in {"Zhou et al.": zhou(), "Lobovsky et al.": lobovsky()}.items():
        found += record.rows_of(study, bench.study(study), what)
    return found


def zhou(cells=80) -> Study:
    """Return the study of the point at 0.267 H against two converged codes, smoothed over 0.1 sqrt(H/g)."""
    names = [f"pressure against {code}" for code in CODES]
    return Study(
        case="dam_break_zhou.py",
        variants=[Variant(label=f"H/s = {cells}", spacings=[1 / cells], parameters={"distance": 5.375})],
        errors=[Function(name, of=partial(error, code=code)) for name, code in zip(names, CODES)],
        required=[Required(name, must=0.05, aim=0.035) for name in names])


def lobovsky(cells=120) -> Study:
    """Return the study of four pressures against one event, and of the peak at S2 against 95 % of a hundred."""
    return Study(
        case="dam_break_lobovsky.py", variants=[Variant(label=f"H/s = {cells}", spacings=[1 / cells])],
        errors=[*(TruthError(sensor, name=f"error at {sensor}") for sensor in SENSORS), Function(PEAK, of=peak)],
        required=[*(Required(f"error at {sensor}", must=limit) for sensor, limit in SENSORS.items()),
                  Required(PEAK, must=0.0)])


def error(run, code) -> float:
    """Return the error of the point's pressure against one of the codes."""
    found = run.summary["errors"]["P2_point"]
    return found["relative_l2"] if code == CODES[0] else found["others"][code]["relative_l2"]


def peak(run) -> float:
    """Return the part of the band's nearer end by which the greatest pressure at S2 is outside the band, 0 inside."""
    band, = run.summary["errors"]["S2"]["peaks"]
    return abs(band["beyond"])
