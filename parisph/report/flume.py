"""Tables of a report: incident and reflected waves in a flume."""

from collections.abc import Iterator

from parisph.report.account import SUMMARY, Content
from parisph.report.entries import Cell, CellTable, number

HEAD = ("waves", "gauges", "from [s]", "to [s]", "depth [m]", "incident height [m]", "reflected height [m]",
        "reflection coefficient", "residual")
BANDS = ("frequency [Hz]", "incident [m²/Hz]", "reflected [m²/Hz]", "reflection coefficient")
WORDS = (
    "By least squares from the elevations at the gauges: Goda and Suzuki (two), Mansard and Funke (three). Heights of "
    "irregular waves are significant ones, of frequencies from half that of the peak to twice that. The residual is "
    "the part of the amplitudes that two waves do not explain. Other gauges or times: parisph reflection."
)


def reflection(summary: Content) -> Iterator[tuple[CellTable, str]]:
    """Yield tables with the words below them; none for a run without a `reflection`."""
    found = summary.get("reflection")
    if not found:
        return
    path = ["reflection"]
    if "reason" in found:
        yield CellTable((), ((Cell("not known"), number(summary, SUMMARY, [*path, "reason"])),)), ""
        return
    columns = (("start", ".4g"), ("end", ".4g"), ("depth", ".4g"), ("incident", ".4g"), ("reflected", ".4g"),
               ("coefficient", ".3g"), ("residual", ".3g"))
    gauges = Cell(", ".join(found["probes"]), f"{SUMMARY}: reflection/probes")
    yield CellTable(HEAD, ((Cell("regular" if found["regular"] else "irregular"), gauges,
                        *(number(summary, SUMMARY, [*path, name], form) for name, form in columns)),)), WORDS
    names = ("frequency", "incident", "reflected", "coefficient")
    rows = tuple(tuple(number(summary, SUMMARY, [*path, "bands", k, name], ".3g") for name in names)
                 for k in range(len(found.get("bands") or ())))
    if rows:
        yield CellTable(BANDS, rows), ""
