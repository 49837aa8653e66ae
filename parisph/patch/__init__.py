"""Patch tests: operators on fields with known derivatives, on particles of the unit square or cube."""
