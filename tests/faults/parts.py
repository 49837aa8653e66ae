"""The parts of the campaign, in their order. One module of this folder holds each of them."""

from tests.faults.table import Part

PARTS: dict[str, Part] = {
}
